"""Axes, grids and tiles: index <-> values, no physics."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Axis:
    """One axis of a sweep.

    Parameters
    ----------
    name : str
        The parameter or state that varies, or what counts where several vary together.
    values : tuple of float
        Its values, in the quantity's unit; whole numbers where it counts.
    along : tuple of (name, values)
        The quantities that vary together along it; none where it is a quantity itself.
    """

    name: str
    values: tuple[float, ...]
    along: tuple[tuple[str, tuple[float, ...]], ...] = ()

    def __len__(self) -> int:
        return len(self.values)

    @property
    def quantities(self) -> dict[str, tuple[float, ...]]:
        """The values of each parameter or state that varies along it, by name."""
        return dict(self.along or ((self.name, self.values),))

    def at(self, index: int) -> dict[str, float]:
        """Return the value of each of them at an index."""
        return {name: float(values[index]) for name, values in self.quantities.items()}

    def picked(self, indices: Sequence[int]) -> Axis:
        """Return the axis with only some of its values."""
        along = tuple((name, tuple(values[i] for i in indices)) for name, values in self.along)
        return Axis(self.name, tuple(self.values[i] for i in indices), along)


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

    @property
    def quantities(self) -> tuple[str, ...]:
        """The parameters and states that vary."""
        return tuple(name for axis in self.axes for name in axis.quantities)

    def coordinates(self, start: int, stop: int) -> dict[str, np.ndarray]:
        """Return the values of all axes in the cells start .. stop - 1, see `coordinates_of`."""
        return self.coordinates_of(np.arange(start, stop))

    def coordinates_of(self, cells: np.ndarray) -> dict[str, np.ndarray]:
        """Return the value of each axis, and of each quantity that varies along one, in some cells.

        Parameters
        ----------
        cells : (n,) int64
            Numbers of the cells, in any order.

        Returns
        -------
        dict of (n,) arrays, by name; an axis stands before what varies along it
        """
        indices = np.unravel_index(cells, self.shape) if self.axes else ()
        return {
            name: np.asarray(values)[i]
            for axis, i in zip(self.axes, indices, strict=True)
            for name, values in ((axis.name, axis.values), *axis.along)
        }

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
