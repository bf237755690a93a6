"""Axes, grids and tiles: index <-> values, no physics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Axis:
    """One axis of a sweep.

    Parameters
    ----------
    name : str
        The parameter or state that varies.
    values : tuple of float
        Its values, in the quantity's unit.
    """

    name: str
    values: tuple[float, ...]

    def __len__(self) -> int:
        return len(self.values)


@dataclass(frozen=True)
class Tile:
    """A contiguous range of cells, `start <= cell < stop`."""

    index: int
    start: int
    stop: int

    def __len__(self) -> int:
        return self.stop - self.start


@dataclass(frozen=True)
class Grid:
    """The product of any number of axes; cells are numbered in C order, the last axis fastest."""

    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values per axis."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of cells; 1 without axes."""
        return math.prod(self.shape)

    def coordinates(self, start: int, stop: int) -> dict[str, np.ndarray]:
        """Return the value of each axis in the cells start .. stop - 1, (stop - start,) float64 each."""
        return self.coordinates_of(np.arange(start, stop))

    def coordinates_of(self, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the value of each axis in some cells, (n,) float64 each."""
        indices = np.unravel_index(cells, self.shape) if self.axes else ()
        return {axis.name: np.asarray(axis.values)[i] for axis, i in zip(self.axes, indices, strict=True)}

    def blocks(self, cells: int) -> Iterator[tuple[slice, ...]]:
        """Yield hyperslabs of at most `cells` cells (or one) that are contiguous in the order of cells.

        They follow each other in that order, so a file can be written from a stream.
        """
        if not self.axes:
            yield ()
            return
        lengths = self.block_shape(cells)
        starts = [range(0, n, length) for n, length in zip(self.shape, lengths, strict=True)]
        for corner in np.ndindex(*(len(s) for s in starts)):
            first = [s[i] for s, i in zip(starts, corner, strict=True)]
            yield tuple(slice(f, min(f + length, n)) for f, length, n in zip(first, lengths, self.shape, strict=True))

    def block_shape(self, cells: int) -> tuple[int, ...]:
        """Return the shape of a block: whole trailing axes, part of one axis, single values of the leading ones."""
        lengths = []
        room = max(cells, 1)
        for n in reversed(self.shape):
            length = min(n, room)
            lengths.append(length)
            room = room // n if length == n else 1
        return tuple(reversed(lengths))

    def span(self, block: tuple[slice, ...]) -> tuple[int, int]:
        """Return the first cell of a block and the one after its last."""
        if not block:
            return 0, 1
        first = int(np.ravel_multi_index([s.start for s in block], self.shape))
        last = int(np.ravel_multi_index([s.stop - 1 for s in block], self.shape))
        return first, last + 1
