"""The conductor: from a sweep and a folder to shards and a result, doing only what is missing."""

from __future__ import annotations

import contextlib
import random
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.codes import Status
from quavsweep.config import Sweep, dump_config, load_sweep
from quavsweep.errors import ConfigError, DamageError, IdentityError, StoppedError, TilesFailedError
from quavsweep.executor import run_tiles
from quavsweep.grid import Tile
from quavsweep.integrate import Plan, integrate_tile, make_plan
from quavsweep.kernels.compiler import default_lanes
from quavsweep.provenance import Identity, changed_keys, evidence_parts, identify, machine, toolchain
from quavsweep.store import RunFolder, ShardSet, read_result, write_outcome, write_shard

TILE_SECONDS = 2.0  # estimated time of a tile: what a kill can lose, against overhead
FEWEST_TILES = 32  # so that workers end together
TILE_MULTIPLE = 32  # whole groups of lanes
LARGEST_TILE = 65536
LARGEST_TILE_BYTES = 2**27  # of evidence


@dataclass
class Progress:
    """How far a run is; updated in place and handed to the observer after each receipt."""

    tiles: int
    cells: int
    tiles_done: int = 0
    cells_done: int = 0
    cells_run: int = 0
    failed: int = 0
    started: float = field(default_factory=time.monotonic)


def choose_tile_cells(plan: Plan) -> int:
    """Return the number of cells per tile from a static cost model, the same on every machine."""
    cell_seconds = plan.clock.steps * plan.step_ns * 1e-9
    size = plan.sweep.grid.size
    wanted = min(
        TILE_SECONDS / cell_seconds, size / FEWEST_TILES, LARGEST_TILE, LARGEST_TILE_BYTES / plan.sweep.cell_bytes
    )
    multiple = TILE_MULTIPLE if wanted >= TILE_MULTIPLE or plan.sweep.cell_bytes < 2**20 else 1
    return max(1, round(wanted / multiple)) * multiple


def run_sweep(
    sweep: Sweep,
    out: Path | str | None = None,
    *,
    workers: int = 2,
    observe: Callable[[Progress], None] = lambda progress: None,
    stop: threading.Event | None = None,
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
    observe : callable
        Gets the progress after each tile.
    stop : threading.Event, optional
        Set it to stop the run; it can be resumed.
    tile_cells, lanes, order_seed : int, optional
        Force a layout or a random order of tiles; the result does not depend on them.

    Raises
    ------
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
    stop = stop or threading.Event()
    folder = RunFolder(Path(out) if out is not None else Path("results") / sweep.name)
    with folder.lock():
        plan = make_plan(sweep, lanes or default_lanes())
        identity = identify(sweep)
        check_folder(folder, sweep, identity)
        record = {"started": time.time(), "evidence": evidence_parts(sweep), "toolchain": toolchain(), **machine()}
        folder.write_config(dump_config(sweep.canonical()))
        folder.write_record(record)
        shards = ShardSet.scan(folder, sweep, identity, tile_cells or choose_tile_cells(plan))
        failed = _complete(plan, shards, workers, observe, stop, order_seed)
        while not _consolidate(folder, sweep, identity, shards, failed, stop):
            failed = _complete(plan, shards, workers, observe, stop, order_seed)
        folder.write_record(record | {"ended": time.time(), "failed": failed})
    if failed:
        raise TilesFailedError(
            f"{len(failed)} of {shards.tiles} tiles raised, the first with {failed[min(failed)].splitlines()[-1]}",
            str(folder.path),
            "the others are in the result; run again to retry",
        )
    return folder.result


def check_folder(folder: RunFolder, sweep: Sweep, identity: Identity) -> None:
    """Refuse a folder that holds the evidence of another sweep, engine, model or toolchain.

    Raises
    ------
    IdentityError
        With the difference, key by key.
    """
    present = folder.identities()
    if not present and not folder.result.exists():
        return
    if not present or (identity.evidence, identity.toolchain, identity.stage) in present:
        if folder.config.exists():
            _check_config(folder, sweep)
        return
    _check_config(folder, sweep)
    known = folder.read_record()
    differences = changed_keys(known.get("evidence", {}), evidence_parts(sweep))
    differences += changed_keys(known.get("toolchain", {}), toolchain())
    raise IdentityError(
        "holds evidence of another engine, model or toolchain",
        str(folder.path),
        f"{_listed(differences)}; choose another --out",
    )


def _listed(differences: list[str]) -> str:
    """Return the first differences in a line."""
    more = [f"and {len(differences) - 6} more"] if len(differences) > 6 else []
    return "; ".join([*differences[:6], *more]) or "the difference is not known"


def _check_config(folder: RunFolder, sweep: Sweep) -> None:
    """Refuse a folder whose config differs in what changes a number."""
    try:
        stored = load_sweep(folder.config).canonical()
    except ConfigError as error:
        if not folder.config.exists():
            return
        raise IdentityError(
            f"its config cannot be read ({error})", str(folder.path), "delete it to have it rebuilt"
        ) from error
    skipped = ("name", "classify")
    differences = changed_keys(
        {k: v for k, v in stored.items() if k not in skipped},
        {k: v for k, v in sweep.canonical().items() if k not in skipped},
    )
    if differences:
        raise IdentityError(
            "holds a different sweep", str(folder.path), f"{_listed(differences)}; choose another --out"
        )


def _complete(
    plan: Plan,
    shards: ShardSet,
    workers: int,
    observe: Callable[[Progress], None],
    stop: threading.Event,
    order_seed: int | None,
) -> dict[int, str]:
    """Run the tiles that no shard covers; return the errors of those that raised."""
    tiles = shards.missing()
    done = shards.tiles - len(tiles)
    cells = plan.sweep.grid.size
    progress = Progress(shards.tiles, cells, done, cells - sum(len(tile) for tile in tiles))
    observe(progress)
    if order_seed is not None:
        random.Random(order_seed).shuffle(tiles)

    def work(tile: Tile) -> Any:
        evidence = integrate_tile(plan, tile, stop.is_set)
        return write_shard(shards.folder, tile, shards.tile_cells, plan.variables, evidence, shards.identity.owner)

    failed = {}
    try:
        for receipt in run_tiles(work, tiles, workers):
            if receipt.fatal:
                raise receipt.error or AssertionError
            if receipt.error is not None:
                failed[receipt.tile.index] = receipt.trace
                progress.failed += 1
            else:
                shards.add(receipt.outcome)
            progress.tiles_done += 1
            progress.cells_done += len(receipt.tile)
            progress.cells_run += len(receipt.tile)
            observe(progress)
    except StoppedError:
        raise StoppedError(
            f"stopped with {progress.tiles_done} of {progress.tiles} tiles done",
            possible="the same command continues it",
        ) from None
    return failed


def _consolidate(
    folder: RunFolder,
    sweep: Sweep,
    identity: Identity,
    shards: ShardSet,
    failed: Mapping[int, str],
    stop: threading.Event,
) -> bool:
    """Write the result unless it is there; return False if shards turned out damaged and were set aside."""
    if not shards.missing():
        with contextlib.suppress(FileNotFoundError, DamageError):
            stored = read_result(folder.result)
            whole = not np.isin(stored.data["status"], (Status.NOT_COMPUTED, Status.FAILED)).any()
            if whole and stored.file_attributes["result_id"] == identity.result:
                return not shards.discard_damaged()
    try:
        write_outcome(folder.result, sweep, identity, shards, failed, stop.is_set)
    except DamageError:
        shards.discard_damaged()
        return False
    return True
