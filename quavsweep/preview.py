"""What a run would do, without doing it: tiles, time and disk."""

from __future__ import annotations

import dataclasses
import math
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quavsweep.clock import Clock
from quavsweep.config import Sweep
from quavsweep.grid import Axis, Grid, Tile
from quavsweep.integrate import integrate_tile
from quavsweep.kernels.compiler import default_lanes
from quavsweep.measures import Evidence
from quavsweep.plan import Plan, make_plan
from quavsweep.provenance import identify
from quavsweep.store import RunFolder, ShardSet, check_folder
from quavsweep.tiling import LARGEST_GROUP_BYTES, bytes_needed, choose_tile_cells

SAMPLED_CELLS = 128  # of the grid, integrated to learn how long a cell takes
SAMPLED_SECONDS = 4.0  # at most, by the cost model


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
        Disk that the missing shards need, and the result at most, which is compressed.
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


def preview_run(
    sweep: Sweep, out: Path | str | None = None, workers: int = 2, stop: threading.Event | None = None
) -> Preview:
    """Return what `run_sweep` would do; nothing is written.

    Raises
    ------
    IdentityError
        If the folder holds a different sweep.
    StoppedError
        If `stop` was set.
    """
    stop = stop or threading.Event()
    folder = RunFolder(Path(out) if out is not None else sweep.folder)
    identity = identify(sweep)
    check_folder(folder, sweep, identity)
    plan = make_plan(sweep, default_lanes())
    shards = ShardSet.scan(folder, sweep, identity, choose_tile_cells(plan))
    damage = shards.damage()
    bad = [*shards.truncated(), *damage.values()]
    for shard in damage:
        if shards.shards.get(shard.tile) == shard:
            del shards.shards[shard.tile]
    missing, cells_missing = shards.tiles - len(shards.shards), sweep.grid.size - shards.cells_done
    steps, seconds = _sample(plan, stop) if missing else (math.nan, 0.0)
    shard_bytes, result_bytes = bytes_needed(sweep, cells_missing)
    return Preview(
        tiles=shards.tiles,
        cells=sweep.grid.size,
        valid=len(shards.shards),
        missing=missing,
        bad=tuple(bad),
        seconds=cells_missing * seconds / min(workers, max(missing, 1)),
        steps_per_cell=steps,
        shard_bytes=shard_bytes,
        result_bytes=result_bytes,
        free_bytes=folder.free_bytes,
    )


def _sample(plan: Plan, stop: threading.Event) -> tuple[float, float]:
    """Return mean steps and mean seconds of a cell, from a few cells that are spread over the grid.

    Where whole cells would take too long, the cells that are left after some segments are taken to go on to the end.
    """
    sweep, lanes = plan.sweep, plan.layout.lanes
    cell_seconds = sweep.clock.steps * plan.step_ns * 1e-9
    wanted = int(min(SAMPLED_CELLS, max(lanes, SAMPLED_SECONDS / cell_seconds)))
    few = Grid(_thinned(sweep.grid.axes, max(1, min(wanted, LARGEST_GROUP_BYTES // sweep.cell_bytes))))
    cells = min(few.size, wanted)
    clock = _shortened(plan, max(cells, lanes), SAMPLED_SECONDS)
    _integrated(plan, few, 1, _shortened(plan, lanes, 0.1), stop)  # what is loaded once is no cost of a cell
    begin = time.perf_counter()
    steps = _integrated(plan, few, cells, clock, stop)["steps"].astype(np.float64)
    seconds = (time.perf_counter() - begin) / max(cells, min(lanes, sweep.grid.size))
    measured = steps.mean()
    steps[steps == clock.steps] = sweep.clock.steps
    return float(steps.mean()), float(seconds * steps.mean() / measured)


def _shortened(plan: Plan, cells: int, seconds: float) -> Clock:
    """Return the clock of a run that integrates so many cells in so many seconds, by the cost model; or a block."""
    clock = plan.clock
    blocks = max(1, int(seconds / (cells * clock.block * plan.step_ns * 1e-9)))
    segments = blocks // (clock.batch_blocks * clock.segment_batches)
    if segments:
        return dataclasses.replace(clock, segments=min(segments, clock.segments))
    return dataclasses.replace(clock, segments=1, segment_batches=1, batch_blocks=min(blocks, clock.batch_blocks))


def _integrated(plan: Plan, grid: Grid, cells: int, clock: Clock, stop: threading.Event) -> Evidence:
    """Integrate the first cells of a grid as long as a clock says."""
    sweep = dataclasses.replace(plan.sweep, grid=grid, clock=clock)
    return integrate_tile(dataclasses.replace(plan, sweep=sweep), Tile(0, 0, cells), stop.is_set)


def _thinned(axes: tuple[Axis, ...], cells: int) -> tuple[Axis, ...]:
    """Return axes with fewer values, evenly chosen, whose product has about so many cells."""
    kept: list[Axis] = []
    for i, axis in enumerate(sorted(axes, key=len)):
        room = (cells / math.prod(len(a) for a in kept)) ** (1 / (len(axes) - i))
        number = min(len(axis), max(1, round(room)))
        picked = np.unique(((np.arange(number) + 0.5) * len(axis) / number).astype(int))
        kept.append(axis.picked(picked.tolist()))
    by_name = {axis.name: axis for axis in kept}
    return tuple(by_name[axis.name] for axis in axes)
