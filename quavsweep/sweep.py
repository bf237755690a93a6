"""From a sweep and a folder to a result, doing only what is missing: run, extend, classify anew."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from quavsweep.conductor import Conductor, consolidate
from quavsweep.config import Sweep, dump_config, load_sweep
from quavsweep.errors import ConfigError, DamageError, DiskError, StoppedError
from quavsweep.executor import Executor, Threads
from quavsweep.kernels.compiler import default_lanes
from quavsweep.models import Model
from quavsweep.plan import make_plan
from quavsweep.progress import Progress
from quavsweep.provenance import evidence_parts, identify, machine, toolchain
from quavsweep.store import Failures, Journal, RunFolder, ShardSet, check_folder
from quavsweep.tiling import bytes_needed, choose_tile_cells

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
    retry_failed: bool = False,
    fail_fast: bool = False,
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
    retry_failed : bool
        Whether tiles that raised in an earlier run are tried again; else they are left out.
    fail_fast : bool
        Whether the first tile that raises ends the run, without a result.
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
    with folder.lock(exclusive), Journal(folder, machine()) as journal:
        plan = make_plan(sweep, lanes or default_lanes())
        identity = identify(sweep)
        check_folder(folder, sweep, identity, accept_toolchain, longer)
        shards = ShardSet.scan(folder, sweep, identity, tile_cells or choose_tile_cells(plan))
        if shards.doubles:
            shards.discard_damaged()  # one of them at least is not what it seems
        _check_disk(folder, shards)
        failures = Failures.scan(folder, identity, shards.tile_cells)
        if retry_failed:
            failures.forget()
        folder.write_model(sweep.model)
        folder.write_config(dump_config(sweep.canonical()))
        progress = Progress(shards.tiles, sweep.grid.size)

        def watch() -> None:
            if observe is not None:
                observe(progress)

        journal.begin(evidence=evidence_parts(sweep), toolchain=toolchain())
        Conductor(plan, folder, shards, failures, executor, journal, progress, watch, stop, fail_fast, order_seed).run()
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
    present.require_evidence("extend", str(folder.path))
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


def reclassify(path: Path | str, changes: Sequence[str] = (), stop: threading.Event | None = None) -> Path:
    """Label the cells of a run anew from its stored evidence, and return the path of the result.

    Parameters
    ----------
    path : Path
        Folder of a run whose tiles are all done.
    changes : sequence of str
        Thresholds that differ from the folder's config, as `classify.errors=4`.
    stop : threading.Event, optional
        Set it to stop; nothing is changed then.

    Raises
    ------
    ConfigError
        If there is no run, or a change is not one of a threshold.
    LockedError, DiskError
        As `run_sweep`.
    StoppedError
        If tiles are missing, or it was stopped; nothing is changed then.
    """
    stop = stop or threading.Event()
    folder = RunFolder(Path(path))
    folder.must_exist()
    with folder.lock():
        before, sweep = load_sweep(folder.config), load_sweep(folder.config, changes)
        before.require_evidence("classify", str(folder.path))
        if any(sweep.settings()[key] != value for key, value in before.settings().items() if key != "classify"):
            raise ConfigError(
                "only thresholds can change here", possible="--set classify.KEY=VALUE; the rest needs run"
            )
        shards = ShardSet.scan(folder, sweep, folder.present_identity(identify(sweep)))
        shards.discard_damaged()
        failures = Failures.scan(folder, shards.identity, shards.tile_cells)
        if missing := sum(tile.index not in failures.errors for tile in shards.missing()):
            what = f"{missing} of {shards.tiles} tiles are missing; nothing was changed"
            raise StoppedError(what, str(folder.path), "run the sweep to complete it")
        waiting = consolidate(folder, shards, failures, stop.is_set, Progress(0, 0))
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
