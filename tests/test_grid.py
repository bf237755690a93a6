"""Grids: every cell once, in order, whatever the tiles and blocks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quavsweep.grid import Axis, Grid


def _grid(shape: tuple[int, ...]) -> Grid:
    return Grid(tuple(Axis(f"a{i}", tuple(10.0 * i + np.arange(n))) for i, n in enumerate(shape)))


shapes = st.lists(st.integers(1, 7), max_size=4).map(tuple)


@given(shapes, st.integers(1, 50))
@settings(deadline=None)
def test_blocks_follow_each_other_in_the_order_of_cells(shape: tuple[int, ...], cells: int) -> None:
    grid = _grid(shape)
    numbers = np.arange(grid.size).reshape(grid.shape)
    spans = [grid.span(block) for block in grid.blocks(cells)]
    for block, (start, stop) in zip(grid.blocks(cells), spans, strict=True):
        np.testing.assert_array_equal(numbers[block].ravel(), np.arange(start, stop))
        assert stop - start <= max(cells, 1)
    assert [start for start, _ in spans] == [0, *(stop for _, stop in spans[:-1])]
    assert spans[-1][1] == math.prod(shape)


def test_coordinates_are_in_c_order() -> None:
    coordinates = _grid((2, 3)).coordinates(1, 5)
    np.testing.assert_array_equal(coordinates["a0"], [0, 0, 1, 1])
    np.testing.assert_array_equal(coordinates["a1"], [11, 12, 10, 11])


@pytest.mark.parametrize("cells", [1, 3, 100])
def test_a_grid_without_axes_is_one_cell(cells: int) -> None:
    grid = _grid(())
    assert grid.size == 1
    assert grid.coordinates(0, 1) == {}
    assert [grid.span(block) for block in grid.blocks(cells)] == [(0, 1)]
