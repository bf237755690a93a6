"""Runs tiles on threads of this process with dask; kernels run without the interpreter's lock."""

from __future__ import annotations

import collections
import contextlib
import queue
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import dask

from quavsweep.errors import ConfigError
from quavsweep.executor.receipt import Receipt, TaskOf, do
from quavsweep.grid import Tile
from quavsweep.memory import release_memory


@dataclass(frozen=True)
class Threads:
    """Does the work of tiles in `workers` threads.

    Raises
    ------
    ConfigError
        If there are none.
    """

    workers: int = 2

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise ConfigError(f"{self.workers} workers cannot work", possible="at least 1")

    def run(self, task_of: TaskOf, tiles: Sequence[Tile], stop: threading.Event) -> Iterator[Receipt]:
        """Yield a receipt for each tile, as they come; tiles are begun in their order."""
        receipts: queue.Queue[Receipt | BaseException | None] = queue.Queue()
        if not tiles:
            return
        abandoned = threading.Event()
        waiting = collections.deque(tiles)

        def stopped() -> bool:
            return stop.is_set() or abandoned.is_set()

        def worker() -> None:
            # One task per worker, not per tile: dask orders 20,000 tiles for half a minute before the first begins.
            with contextlib.suppress(IndexError):
                while not abandoned.is_set():
                    tile = waiting.popleft()
                    receipts.put(do(lambda tile=tile: task_of(tile)(stopped), tile))  # type: ignore[misc]

        def drive() -> None:
            try:
                tasks = [dask.delayed(worker, pure=False)() for _ in range(min(self.workers, len(tiles)))]
                dask.compute(*tasks, scheduler="threads", num_workers=len(tasks))
                receipts.put(None)
            except BaseException as error:
                receipts.put(error)

        driver = threading.Thread(target=drive, name="quavsweep-driver", daemon=True)
        driver.start()
        try:
            while True:
                item = receipts.get()
                if item is None:
                    return
                if isinstance(item, BaseException):
                    raise item
                yield item
        finally:
            abandoned.set()
            driver.join()
            release_memory()  # the heaps of the threads
