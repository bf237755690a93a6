"""The conductor: does what is missing of a sweep, tile by tile, and makes a result of it."""

from __future__ import annotations

import contextlib
import random
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial

from quavsweep.codes import STATUS, Status
from quavsweep.errors import STOPPED, ConfigError, DamageError, DiskError, StoppedError, TilesFailedError
from quavsweep.executor import Executor, Receipt, Task, Threads
from quavsweep.grid import Tile
from quavsweep.plan import Plan
from quavsweep.progress import Progress
from quavsweep.store import Failures, Journal, RunFolder, Shard, ShardSet, code_counts, read_result
from quavsweep.store.outcome import write_outcome
from quavsweep.tiling import spread
from quavsweep.work import Errand, Order, Worker

SEEN_SECONDS = 10.0  # within which a shard is seen that was published on another machine


@dataclass
class Conductor:
    """Does what is missing of a sweep.

    Parameters
    ----------
    plan : Plan
    folder : RunFolder
    shards : ShardSet
        What is there; shards that are published join it.
    failures : Failures
        Tiles that raised, which are left out; those that raise join it.
    executor : Executor
        Runs the tiles.
    journal : Journal
    progress : Progress
    watch : callable
        Called when the progress has changed.
    stop : threading.Event
    fail_fast : bool
        Whether the first tile that raises ends the run.
    order_seed : int, optional
        Of a random order of tiles.
    """

    plan: Plan
    folder: RunFolder
    shards: ShardSet
    failures: Failures
    executor: Executor
    journal: Journal
    progress: Progress
    watch: Callable[[], None]
    stop: threading.Event
    fail_fast: bool = False
    order_seed: int | None = None

    def run(self) -> None:
        """Do everything that is missing, and write the result.

        Raises
        ------
        TilesFailedError
            If tiles raised; the result is written all the same, unless the first was to end the run.
        StoppedError, DiskError, IdentityError
            As `run_sweep`.
        """
        try:
            self._complete()
            while consolidate(self.folder, self.shards, self.failures, self.stopped, self.progress) is None:
                self._complete()
        finally:
            error, failed = self.progress.step_error, sorted(self.failures.errors)
            self.journal.note(tiles=self.shards.tiles, tiles_done=len(self.shards.shards), tiles_failed=failed)
            self.journal.note(**({} if error is None else {"step_error": asdict(error)}))
        if self.failures.errors:
            raise self._failed("the others are in the result")

    def stopped(self) -> bool:
        """Tell that something has moved on, and whether to stop."""
        self.watch()
        return self.stop.is_set()

    def _failed(self, rest: str) -> TilesFailedError:
        what = f"{len(self.failures.errors)} of {self.shards.tiles} tiles raised"
        return TilesFailedError(
            f"{what}, the first with {self.failures.first_error}",
            str(self.folder.path),
            f"{rest}; tracebacks are in {self.folder.failed.name}/, and --retry-failed tries again",
        )

    def _complete(self) -> None:
        """Run the tiles that no shard covers, and passes of the effort, but for those that have raised.

        Where a shard turns out damaged from which a tile goes on, it is set aside and the tile done again.
        """
        missing = [tile for tile in self.shards.missing() if tile.index not in self.failures.errors]
        tiles = self._tiles(missing)
        progress = self.progress
        progress.stage, progress.failed = "integrating", len(self.failures.errors)
        progress.tiles_done = len(self.shards.shards)
        progress.cells_done = self.shards.cells_done
        self.watch()
        fresh = {tile.index for tile in missing}
        torn = list[Receipt]()
        try:
            for receipt in self.executor.run(self._tasks(), tiles, self.stop):
                if isinstance(receipt.error, DamageError):
                    torn.append(receipt)
                else:
                    self._take(receipt, receipt.tile.index in fresh)
                self.watch()
        except StoppedError as error:
            why = "" if error.what == STOPPED else f"{error}; "
            raise StoppedError(
                f"{why}stopped with {progress.tiles_done} of {progress.tiles} tiles done",
                possible="the same command continues it",
            ) from None
        if torn and self.shards.discard_damaged():
            self._complete()
        else:
            for receipt in torn:
                self._take(receipt, fresh=False)

    def _tiles(self, missing: list[Tile]) -> list[Tile]:
        """Return the tiles to run, in their order; where there is an effort all may have passes to do."""
        shards = self.shards
        if shards.sweep.config.effort is None:
            tiles = spread(missing)
        else:
            every = map(shards.tile, range(shards.tiles))
            tiles = spread(tile for tile in every if tile.index not in self.failures.errors)
        if self.order_seed is not None:
            random.Random(self.order_seed).shuffle(tiles)
        return tiles

    def _tasks(self) -> Callable[[Tile], Task]:
        """Return what makes the work of a tile, for threads of this process or for workers elsewhere."""
        if isinstance(self.executor, Threads):
            worker = Worker(self.plan, self.shards)
            return lambda tile: partial(worker, tile)
        order, begun = Order.of(self.plan, self.shards, self.folder.path), set[int]()

        def errand(tile: Tile) -> Errand:
            # A tile that is begun again was lost with its worker, which may have published it.
            known = None if tile.index in begun else self.shards.names(tile.index)
            begun.add(tile.index)
            return Errand(order, tile, self.progress.step_error is None, known)

        return errand

    def _take(self, receipt: Receipt, fresh: bool) -> None:
        """Take in what became of a tile."""
        tile, progress = receipt.tile, self.progress
        if receipt.fatal:
            raise receipt.error or AssertionError
        if receipt.error is not None:
            self.failures.add(tile, receipt.error_line, receipt.trace)
            progress.failed += 1
            self.journal.tell("failed", tile=tile.index, error=receipt.error_line)
            if self.fail_fast:
                raise self._failed("the run ended with it")
            return
        done = receipt.outcome
        for shard in done.shards:
            _see(shard)
            self.shards.add(shard)
        progress.step_error = progress.step_error or done.step_error
        if fresh:
            progress.add(len(tile), done.steps, done.regions)
            self.journal.tell("tile", tile=tile.index, cells=len(tile), steps=done.steps, worker=receipt.worker)


def _see(shard: Shard) -> None:
    """Make sure that a shard which a worker has published is seen here; on some file systems that takes a while."""
    deadline = time.monotonic() + SEEN_SECONDS
    while not shard.is_there:
        if time.monotonic() > deadline:
            what = "a worker published this shard, but it is not seen here"
            raise DiskError(what, str(shard.path), "workers and this process must share the folder")
        time.sleep(0.1)


def consolidate(
    folder: RunFolder, shards: ShardSet, failures: Failures, stopped: Callable[[], bool], progress: Progress
) -> int | None:
    """Write the result unless it is there; return how many cells wait for a pass of the effort.

    None if shards are missing whose tiles did not raise: they turned out damaged and were set aside.

    Raises
    ------
    StoppedError, DiskError
        As `run_sweep`.
    """
    missing = shards.missing()
    if any(tile.index not in failures.errors for tile in missing):
        return None
    if not missing and shards.sweep.config.effort is None:
        # One that is too large for a file from elsewhere, as it seems without the ledger, is made again.
        with contextlib.suppress(FileNotFoundError, DamageError, ConfigError):
            stored = read_result(folder.result)
            ours = stored.file_attributes["result_id"] == shards.identity.result
            count = code_counts(stored, "status", STATUS) if ours else None
            if count is not None and not count[[Status.NOT_COMPUTED, Status.FAILED]].any():
                return None if shards.discard_damaged() else 0
    progress.stage = "writing the result"
    try:
        waiting = write_outcome(folder.result, shards, failures.errors, stopped)
        shards.discard_damaged(unread=True)  # the result does without them, but nothing damaged stays
        return waiting
    except DamageError:
        shards.discard_damaged()
        return None
