"""The conductor: from a sweep and a folder to shards and a result, doing only what is missing."""

from __future__ import annotations

import contextlib
import random
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.codes import Status
from quavsweep.config import Sweep, dump_config, load_sweep
from quavsweep.errors import STOPPED, ConfigError, DamageError, DiskError, StoppedError, TilesFailedError
from quavsweep.executor import Executor, Task, Threads
from quavsweep.grid import Tile
from quavsweep.kernels.compiler import default_lanes
from quavsweep.models import Model
from quavsweep.plan import Plan, make_plan
from quavsweep.progress import Progress
from quavsweep.provenance import evidence_parts, identify, machine, toolchain
from quavsweep.store import RunFolder, Shard, ShardSet, check_folder, read_result
from quavsweep.store.outcome import write_outcome
from quavsweep.tiling import bytes_needed, choose_tile_cells, spread
from quavsweep.work import Errand, Order, Worker

SEEN_SECONDS = 10.0  # within which a shard is seen that was published on another machine

Observer = Callable[[Progress], None]


def run_sweep(
    sweep: Sweep,
    out: Path | str | None = None,
    *,
    workers: int = 2,
    executor: Executor | None = None,
    observe: Observer | None = None,
    stop: threading.Event | None = None,
    accept_toolchain: bool = False,
    exclusive: bool = True,
    longer: bool = False,
    tile_cells: int | None = None,
    lanes: int | None = None,
    order_seed: int | None = None,
) -> Path:
    """Run a sweep, or what is missing of it, and return the path of its result.

    Parameters
    ----------
    sweep : Sweep
    out : Path, optional
        Folder of the run; default `results/<name>`.
    workers : int
        Number of threads.
    executor : Executor, optional
        What runs the tiles instead of threads of this process.
    observe : callable
        Gets the progress after each tile.
    stop : threading.Event, optional
        Set it to stop the run; it can be resumed.
    accept_toolchain : bool
        Whether to start anew in a folder that holds the evidence of other versions of compilers or libraries.
    exclusive : bool
        Whether to lock the folder against other runs; two at a time do the same work twice.
    longer : bool
        Whether the folder may hold a shorter run of the same sweep, which is then taken on.
    tile_cells, lanes, order_seed : int, optional
        Force a layout or a random order of tiles; the result does not depend on them.

    Raises
    ------
    ConfigError
        If there are no workers.
    IdentityError
        If the folder holds a different sweep.
    LockedError
        If another run holds the folder.
    DiskError
        If the disk is full or refuses.
    StoppedError
        If the run was stopped.
    TilesFailedError
        If tiles raised; the result is written all the same.
    """
    executor = executor or Threads(workers)
    stop = stop or threading.Event()
    folder = RunFolder(Path(out) if out is not None else sweep.folder)
    with folder.lock(exclusive):
        plan = make_plan(sweep, lanes or default_lanes())
        identity = identify(sweep)
        check_folder(folder, sweep, identity, accept_toolchain, longer)
        shards = ShardSet.scan(folder, sweep, identity, tile_cells or choose_tile_cells(plan))
        if shards.doubles:
            shards.discard_damaged()  # one of them at least is not what it seems
        _check_disk(folder, shards)
        record = {"started": time.time(), "evidence": evidence_parts(sweep), "toolchain": toolchain(), **machine()}
        folder.write_model(sweep.model)
        folder.write_config(dump_config(sweep.canonical()))
        folder.write_record(record)
        progress = Progress(shards.tiles, sweep.grid.size)

        def watch() -> None:
            if observe is not None:
                observe(progress)

        failed = _complete(plan, shards, folder, executor, progress, watch, stop, order_seed)
        while _consolidate(folder, shards, failed, progress, watch, stop) is None:
            failed = _complete(plan, shards, folder, executor, progress, watch, stop, order_seed)
        folder.write_record(record | {"ended": time.time(), "failed": failed, **_step_record(progress)})
    if failed:
        raise TilesFailedError(
            f"{len(failed)} of {shards.tiles} tiles raised, the first with {failed[min(failed)].splitlines()[-1]}",
            str(folder.path),
            "the others are in the result; run again to retry",
        )
    return folder.result


def extend_sweep(
    path: Path | str,
    duration: float,
    *,
    model: Model | Path | str | None = None,
    workers: int = 2,
    observe: Observer | None = None,
    stop: threading.Event | None = None,
) -> Path:
    """Take a run on to a longer duration, from its checkpoints, and return the path of the result.

    The result has the same bytes as that of a run of this duration, with the same batch, from the start.

    Parameters
    ----------
    path : Path
        Folder of the run.
    duration : float
        Time over which exponents are averaged, in the model's time; rounded up to whole segments. An effort that
        reaches less far is raised to it.
    model : Model or Path, optional
        The model, or the file that makes it, if it is not of the catalogue.

    Raises
    ------
    ConfigError
        If there is no run, or it is longer already.
    IdentityError, LockedError, DiskError, StoppedError, TilesFailedError
        As `run_sweep`.
    """
    folder = RunFolder(Path(path))
    folder.must_exist()
    present = load_sweep(folder.config)
    changes = [f"integrate.duration={float(duration)!r}"]
    if present.config.effort is not None and present.config.effort.max_duration < duration:
        changes.append(f"effort.max_duration={float(duration)!r}")
    sweep = load_sweep(folder.config, changes, model)
    if sweep.clock.steps < present.clock.steps:
        raise ConfigError(
            f"a duration of {duration:g} is shorter than that of the run",
            str(folder.path),
            f"at least {present.clock.duration:g}; plot --horizon shows what a shorter run would have said",
        )
    return run_sweep(sweep, folder.path, workers=workers, observe=observe, stop=stop, longer=True)


def _step_record(progress: Progress) -> dict[str, Any]:
    return {} if progress.step_error is None else {"step_error": asdict(progress.step_error)}


def reclassify(path: Path | str, changes: Sequence[str] = ()) -> Path:
    """Label the cells of a run anew from its stored evidence, and return the path of the result.

    Parameters
    ----------
    path : Path
        Folder of a run whose tiles are all done.
    changes : sequence of str
        Thresholds that differ from the folder's config, as `classify.errors=4`.

    Raises
    ------
    ConfigError
        If there is no run, or a change is not one of a threshold.
    LockedError, DiskError
        As `run_sweep`.
    StoppedError
        If tiles are missing; nothing is changed then.
    """
    folder = RunFolder(Path(path))
    folder.must_exist()
    with folder.lock():
        before, sweep = load_sweep(folder.config).settings(), load_sweep(folder.config, changes)
        if any(sweep.settings()[key] != value for key, value in before.items() if key != "classify"):
            raise ConfigError(
                "only thresholds can change here", possible="--set classify.KEY=VALUE; the rest needs run"
            )
        shards = ShardSet.scan(folder, sweep, folder.present_identity(identify(sweep)))
        shards.discard_damaged()
        if missing := shards.tiles - len(shards.shards):
            what = f"{missing} of {shards.tiles} tiles are missing; nothing was changed"
            raise StoppedError(what, str(folder.path), "run the sweep to complete it")
        waiting = _consolidate(folder, shards, {}, Progress(0, 0), lambda: None, threading.Event())
        if waiting is None:
            raise DamageError("shards were damaged while they were read", str(folder.path), "run the sweep again")
        folder.write_config(dump_config(sweep.canonical()))
    if waiting:
        effort = sweep.config.effort
        regions_of = " or ".join(effort.of if effort else ())
        what = f"{waiting} cells are {regions_of} by these thresholds and have not gone on yet"
        raise StoppedError(what, str(folder.path), "the rest is labelled; run the sweep to let them go on")
    return folder.result


def _check_disk(folder: RunFolder, shards: ShardSet) -> None:
    """Refuse a run whose shards cannot fit on the disk."""
    needed, free = bytes_needed(shards.sweep, shards.sweep.grid.size - shards.cells_done)[0], folder.free_bytes
    if needed > free:
        raise DiskError(
            f"the shards need {needed:.3g} bytes, {free:.3g} are free", str(folder.path), "choose another --out"
        )


def _complete(
    plan: Plan,
    shards: ShardSet,
    folder: RunFolder,
    executor: Executor,
    progress: Progress,
    watch: Callable[[], None],
    stop: threading.Event,
    order_seed: int | None,
) -> dict[int, str]:
    """Run the tiles that no shard covers, and passes of the effort; return the errors of those that raised."""
    missing = shards.missing()
    tiles = spread(missing if plan.sweep.config.effort is None else map(shards.tile, range(shards.tiles)))
    progress.stage = "integrating"
    progress.tiles_done = shards.tiles - len(missing)
    progress.cells_done = progress.cells - sum(len(tile) for tile in missing)
    watch()
    if order_seed is not None:
        random.Random(order_seed).shuffle(tiles)

    fresh = {tile.index for tile in missing}
    task_of = _tasks(plan, shards, folder, executor, progress)
    failed = {}
    try:
        for receipt in executor.run(task_of, tiles, stop):
            if receipt.fatal:
                raise receipt.error or AssertionError
            if receipt.error is not None:
                failed[receipt.tile.index] = receipt.trace
                progress.failed += 1
            else:
                for shard in receipt.outcome.shards:
                    _see(shard)
                    shards.add(shard)
                progress.step_error = progress.step_error or receipt.outcome.step_error
                if receipt.tile.index in fresh:
                    progress.add(len(receipt.tile), receipt.outcome.steps, receipt.outcome.regions)
            watch()
    except StoppedError as error:
        why = "" if error.what == STOPPED else f"{error}; "
        raise StoppedError(
            f"{why}stopped with {progress.tiles_done} of {progress.tiles} tiles done",
            possible="the same command continues it",
        ) from None
    return failed


def _see(shard: Shard) -> None:
    """Make sure that a shard which a worker has published is seen here; on some file systems that takes a while."""
    deadline = time.monotonic() + SEEN_SECONDS
    while not shard.is_there:
        if time.monotonic() > deadline:
            what = "a worker published this shard, but it is not seen here"
            raise DiskError(what, str(shard.path), "workers and this process must share the folder")
        time.sleep(0.1)


def _tasks(
    plan: Plan, shards: ShardSet, folder: RunFolder, executor: Executor, progress: Progress
) -> Callable[[Tile], Task]:
    """Return what makes the work of a tile, for threads of this process or for workers elsewhere."""
    if isinstance(executor, Threads):
        worker = Worker(plan, shards)
        return lambda tile: partial(worker, tile)
    order = Order.of(plan, shards, folder.path)
    return lambda tile: Errand(order, tile, check=progress.step_error is None)


def _consolidate(
    folder: RunFolder,
    shards: ShardSet,
    failed: Mapping[int, str],
    progress: Progress,
    watch: Callable[[], None],
    stop: threading.Event,
) -> int | None:
    """Write the result unless it is there; return how many cells wait for a pass of the effort.

    None if shards are missing whose tiles did not fail: they turned out damaged and were set aside.
    """
    missing = shards.missing()
    if any(tile.index not in failed for tile in missing):
        return None
    if not missing and shards.sweep.config.effort is None:
        with contextlib.suppress(FileNotFoundError, DamageError):
            stored = read_result(folder.result)
            whole = not np.isin(stored.data["status"], (Status.NOT_COMPUTED, Status.FAILED)).any()
            if whole and stored.file_attributes["result_id"] == shards.identity.result:
                return None if shards.discard_damaged() else 0
    progress.stage = "writing the result"

    def stopped() -> bool:
        watch()
        return stop.is_set()

    try:
        return write_outcome(folder.result, shards, failed, stopped)
    except DamageError:
        shards.discard_damaged()
        return None
