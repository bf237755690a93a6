"""The cells that two results have in common: where each lies in both, and their values, a box of cells at a time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from quavsweep.errors import ConfigError
from quavsweep.grid import Axis, Grid
from quavsweep.result import Result

ROUNDING = 1e-12  # share of itself by which a value of an axis may differ and be the same one, computed otherwise
BOX_BYTES = 2**26  # of the evidence of a box of cells, about
Box = dict[str, slice]  # by name of an axis: some of the values in common


@dataclass(frozen=True)
class Common:
    """Two results and where the cells of both lie in each.

    Parameters
    ----------
    a, b : Result
    indices : dict of pairs of (n,) int
        For each axis of `a`, in its order: which of its values are in both, by their index in `a` and in `b`.
    """

    a: Result
    b: Result
    indices: dict[str, tuple[np.ndarray, np.ndarray]]

    @cached_property
    def grid(self) -> Grid:
        """The grid of the cells in common."""
        axes = self.a.sweep.grid.axes
        return Grid(tuple(axis.picked([int(i) for i in self.indices[axis.name][0]]) for axis in axes))

    @property
    def whole(self) -> bool:
        """Whether both have the same axes in the same order, and every cell is in both."""
        grids = self.a.sweep.grid, self.b.sweep.grid
        return grids[0].shape == grids[1].shape == self.grid.shape and all(
            one.name == other.name for one, other in zip(*(grid.axes for grid in grids), strict=True)
        )

    def boxes(self, axes: tuple[str, ...] | None = None) -> Iterator[Box]:
        """Yield boxes of cells, or of points along some axes, in the order of cells; none is large in either result."""
        names = tuple(self.indices) if axes is None else axes
        room = max(1, BOX_BYTES // max(self.a.sweep.cell_bytes, self.b.sweep.cell_bytes))
        yield from self._split({name: slice(0, len(self.indices[name][0])) for name in names}, room)

    def _split(self, box: Box, room: int) -> Iterator[Box]:
        """Yield a box, or parts of it, none of which spans more cells than there is room for."""
        longer = next((name for name, part in box.items() if part.stop - part.start > 1), None)
        if longer is None or max(self._spanned(box, side) for side in (0, 1)) <= room:
            yield box
            return
        start, stop = box[longer].start, box[longer].stop
        middle = (start + stop) // 2
        for part in (slice(start, middle), slice(middle, stop)):
            yield from self._split({**box, longer: part}, room)

    def _spanned(self, box: Box, side: int) -> int:
        """Return how many cells of one of the results lie between those of a box."""
        indices = (self.indices[name][side][part] for name, part in box.items())
        return math.prod(int(np.ptp(index)) + 1 for index in indices)

    def cells(self, box: Box) -> np.ndarray:
        """Return the numbers of a box's cells in the grid in common, (n,) int."""
        ranges = [np.arange(part.start, part.stop) for part in box.values()]
        if not ranges:
            return np.zeros(1, dtype=int)
        return np.asarray(np.ravel_multi_index(np.ix_(*ranges), self.grid.shape)).ravel()

    def read(self, name: str, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return a variable of both in a box, (n, ...) each, in the same order."""
        return self.read_one(0, name, box), self.read_one(1, name, box)

    def read_one(self, side: int, name: str, box: Box) -> np.ndarray:
        """Return a variable of the first (0) or second (1) in a box, (n, ...), in the order of its cells."""
        result = (self.a, self.b)[side]
        dims = [dim for dim in result.stored.dims[name] if dim in box]
        indices = [self.indices[dim][side][box[dim]] for dim in dims]
        first = [int(index.min()) for index in indices]
        part = tuple(slice(low, int(index.max()) + 1) for low, index in zip(first, indices, strict=True))
        values = np.asarray(result.part(name, part))
        values = values[np.ix_(*(index - low for low, index in zip(first, indices, strict=True)))]
        order = [dims.index(dim) for dim in box]
        values = values.transpose(*order, *range(len(order), values.ndim))
        return np.asarray(values.reshape(-1, *values.shape[len(order) :]))


def find_common(a: Result, b: Result) -> Common:
    """Return the cells that two results have in common.

    Raises
    ------
    ConfigError
        If their axes are others, or no cell is in both.
    """
    axes = [{axis.name: axis for axis in result.sweep.grid.axes} for result in (a, b)]
    quantities = [{name: set(axis.quantities) for name, axis in own.items()} for own in axes]
    if quantities[0] != quantities[1]:
        told = [", ".join(_told(axis) for axis in own.values()) or "none" for own in axes]
        what = f"the axes of the first are {told[0]}, those of the second {told[1]}"
        raise ConfigError(what, possible="only results over the same axes can be compared")
    indices = {name: _matching(axis, axes[1][name]) for name, axis in axes[0].items()}
    for name, (found, _) in indices.items():
        if not found.size:
            what = f"they have no cell in common: no value of {name} is in both"
            raise ConfigError(
                what, possible=f"{_ends(axes[0][name])} in the first, {_ends(axes[1][name])} in the second"
            )
    return Common(a, b, indices)


def _told(axis: Axis) -> str:
    return f"{axis.name} (of {', '.join(axis.quantities)})" if axis.along else axis.name


def _ends(axis: Axis) -> str:
    """Return between which values an axis lies."""
    ends = (f"{name} {min(values):g} to {max(values):g}" for name, values in axis.quantities.items())
    return f"{len(axis)} values, {', '.join(ends)}"


def _matching(a: Axis, b: Axis) -> tuple[np.ndarray, np.ndarray]:
    """Return which values of two axes are the same, by their indices in both, (n,) int each, ascending in the first.

    Along a curve, or among drawn starts, all quantities must be.
    """
    values = ((np.array(a.quantities[name]), np.array(b.quantities[name])) for name in a.quantities)
    numbers = np.stack([_numbered(np.concatenate(pair)) for pair in values], axis=1)
    number = np.unique(numbers, axis=0, return_inverse=True)[1].ravel()
    _, one, other = np.intersect1d(number[: len(a)], number[len(a) :], return_indices=True)
    order = np.argsort(one)
    return one[order], other[order]


def _numbered(values: np.ndarray) -> np.ndarray:
    """Return a number for each value, the same one for values that differ by rounding alone, (n,) int."""
    order = np.argsort(values)
    size = np.abs(values[order])
    gap = np.diff(values[order], prepend=values[order[0]])
    numbers = np.empty(len(values), dtype=int)
    numbers[order] = np.cumsum(gap > ROUNDING * size + 16 * np.finfo(float).eps * size.max())
    return numbers
