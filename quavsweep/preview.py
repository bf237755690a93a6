"""What a run would do, without doing it: tiles, time and disk."""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quavsweep.classify import result_variables
from quavsweep.config import Sweep
from quavsweep.errors import DamageError
from quavsweep.grid import Axis, Grid, Tile
from quavsweep.integrate import Plan, integrate_tile, make_plan
from quavsweep.kernels.compiler import default_lanes
from quavsweep.provenance import identify
from quavsweep.store import RunFolder, ShardSet, check_folder
from quavsweep.tiling import choose_tile_cells

SAMPLED_CELLS = 128  # of the grid, integrated to learn how long a cell takes
SAMPLED_SECONDS = 10.0  # at most, by the cost model


@dataclass(frozen=True)
class Preview:
    """What a run would find and need.

    Parameters
    ----------
    tiles, cells : int
        Of the sweep.
    valid, missing : int
        Tiles whose shard is there and good; tiles that would be done.
    bad : tuple of str
        What is wrong with shards that would be done again.
    seconds : float
        Estimated time of the missing tiles [s], by integrating a few cells.
    steps_per_cell : float
        Mean number of steps of those cells, which early ends make fewer.
    shard_bytes, result_bytes : int
        Disk that all shards need, and the result at most, which is compressed.
    free_bytes : int
        Free on that disk.
    """

    tiles: int
    cells: int
    valid: int
    missing: int
    bad: tuple[str, ...]
    seconds: float
    steps_per_cell: float
    shard_bytes: int
    result_bytes: int
    free_bytes: int


def preview_run(sweep: Sweep, out: Path | str | None = None, workers: int = 2) -> Preview:
    """Return what `run_sweep` would do; nothing is written.

    Raises
    ------
    IdentityError
        If the folder holds a different sweep.
    """
    folder = RunFolder(Path(out) if out is not None else Path("results") / sweep.name)
    identity = identify(sweep)
    check_folder(folder, sweep, identity)
    plan = make_plan(sweep, default_lanes())
    shards = ShardSet.scan(folder, sweep, identity, choose_tile_cells(plan))
    bad = shards.truncated()
    for index in sorted(shards.shards):
        try:
            shards.read(index, {})
        except DamageError as error:
            bad.append(str(error))
            del shards.shards[index]
    extents, size = sweep.extents, sweep.grid.size
    missing, cells_missing = shards.tiles - len(shards.shards), size - shards.cells_done
    steps, seconds = _sample(plan) if missing else (math.nan, 0.0)
    result_bytes = sum(np.dtype(v.dtype).itemsize * math.prod(v.shape(size, extents)) for v in result_variables(sweep))
    return Preview(
        tiles=shards.tiles,
        cells=size,
        valid=len(shards.shards),
        missing=missing,
        bad=tuple(bad),
        seconds=cells_missing * seconds / min(workers, max(missing, 1)),
        steps_per_cell=steps,
        shard_bytes=size * sweep.cell_bytes,
        result_bytes=result_bytes,
        free_bytes=folder.free_bytes,
    )


def _sample(plan: Plan) -> tuple[float, float]:
    """Return mean steps and mean seconds of a cell, from a few cells that are spread over the grid."""
    sweep, lanes = plan.sweep, plan.layout.lanes
    cell_seconds = sweep.clock.steps * plan.step_ns * 1e-9
    wanted = max(lanes, min(SAMPLED_CELLS, int(SAMPLED_SECONDS / cell_seconds)))
    few = Grid(_thinned(sweep.grid.axes, wanted))
    sample = dataclasses.replace(plan, sweep=dataclasses.replace(sweep, grid=few))
    tile = Tile(0, 0, min(few.size, wanted))
    integrate_tile(sample, Tile(0, 0, 1), _not_stopped)  # what is loaded once is no cost of a cell
    begin = time.perf_counter()
    steps = integrate_tile(sample, tile, _not_stopped)["steps"]
    seconds = time.perf_counter() - begin
    # Lanes that stay empty here are full in a large tile.
    return float(steps.mean()), seconds / max(len(tile), min(lanes, sweep.grid.size))


def _thinned(axes: tuple[Axis, ...], cells: int) -> tuple[Axis, ...]:
    """Return axes with fewer values, evenly chosen, whose product has about so many cells."""
    kept: list[Axis] = []
    for i, axis in enumerate(sorted(axes, key=len)):
        room = (cells / math.prod(len(a) for a in kept)) ** (1 / (len(axes) - i))
        number = min(len(axis), max(1, round(room)))
        picked = np.unique(((np.arange(number) + 0.5) * len(axis) / number).astype(int))
        kept.append(Axis(axis.name, tuple(axis.values[j] for j in picked)))
    by_name = {axis.name: axis for axis in kept}
    return tuple(by_name[axis.name] for axis in axes)


def _not_stopped() -> bool:
    return False
