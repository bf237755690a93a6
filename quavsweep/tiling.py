"""Tiles: how many cells one has, from a static cost model, and in which order they are done."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from quavsweep.classify import result_variables
from quavsweep.config import Sweep
from quavsweep.content import content_bytes
from quavsweep.grid import Tile
from quavsweep.kernels.layout import FEWEST_LANES
from quavsweep.plan import Plan

TILE_SECONDS = 8.0  # estimated, without early ends: what a kill can lose, against overhead (57 s with 4, 48 s with 8)
FEWEST_TILES = 16  # so that workers end together
ALIKE = 4  # tiles come in fours of nearly equal size, so that two or four workers end together where cells cost alike
TILE_MULTIPLE = 32  # whole groups of lanes
LARGEST_TILE = 65536
LARGEST_TILE_BYTES = 2**24  # of evidence; a worker holds a few times as much
LARGEST_GROUP_BYTES = 2**27  # where a single group of lanes has more than that


def choose_tile_cells(plan: Plan) -> int:
    """Return the number of cells per tile from a static cost model, the same on every machine."""
    cell_seconds = plan.clock.steps * plan.step_ns * 1e-9
    size, cell_bytes = plan.sweep.grid.size, plan.sweep.cell_bytes
    room = max(LARGEST_TILE_BYTES / cell_bytes, min(FEWEST_LANES, LARGEST_GROUP_BYTES / cell_bytes))
    wanted = min(TILE_SECONDS / cell_seconds, size / FEWEST_TILES, LARGEST_TILE, room)
    multiple = TILE_MULTIPLE if wanted >= TILE_MULTIPLE or cell_bytes < 2**20 else 1
    tiles = ALIKE * math.ceil(size / wanted / ALIKE)
    return math.ceil(size / tiles / multiple) * multiple


def bytes_needed(sweep: Sweep, cells: int) -> tuple[int, int]:
    """Return the size of the shards of so many cells, and that of the result of all, before it is compressed."""
    variables, extents = result_variables(sweep), sweep.extents
    result = sum(np.dtype(v.dtype).itemsize * math.prod(v.shape(sweep.grid.size, extents)) for v in variables)
    return cells * content_bytes(sweep), result


def spread(tiles: Iterable[Tile]) -> list[Tile]:
    """Return tiles in an order of which any beginning is spread evenly over all of them.

    Multiples of the golden ratio, so that what is done so far is a fair sample: of the time that is left, and of the
    regions. The first tile lies well inside the grid (the 17th of 40), because the error of the step is measured there.
    """
    return sorted(tiles, key=lambda tile: (0.5 + tile.index * 0.6180339887498949) % 1.0)
