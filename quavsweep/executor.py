"""Runs tiles on threads with dask and yields their receipts as they come; the only place that imports dask."""

from __future__ import annotations

import collections
import contextlib
import ctypes
import queue
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import dask

from quavsweep.errors import DiskError, StoppedError
from quavsweep.grid import Tile

Work = Callable[[Tile], Any]


@dataclass(frozen=True)
class Receipt:
    """What became of a tile: what the work returned, or the error that it raised.

    `fatal` tells an error that ends the run (a stop, a full disk) from one that concerns this tile alone.
    """

    tile: Tile
    outcome: Any = None
    error: BaseException | None = None
    trace: str = ""

    @property
    def fatal(self) -> bool:
        """Whether the run cannot go on."""
        return isinstance(self.error, StoppedError | DiskError)


def run_tiles(work: Work, tiles: Sequence[Tile], workers: int) -> Iterator[Receipt]:
    """Do the work of all tiles, `workers` at a time, and yield a receipt for each.

    Parameters
    ----------
    work : callable
        From a tile to something small; it runs in threads, and what it raises comes back in the receipt.
    tiles : sequence of Tile
        Begun in this order.
    workers : int
        Number of threads.
    """
    receipts: queue.Queue[Receipt | BaseException | None] = queue.Queue()
    if not tiles:
        return
    abandoned = threading.Event()

    waiting = collections.deque(tiles)

    def worker() -> None:
        # One task per worker, not per tile: dask would order 20,000 tiles for half a minute before the first begins.
        with contextlib.suppress(IndexError):
            while not abandoned.is_set():
                receipts.put(_do(work, waiting.popleft()))

    def drive() -> None:
        try:
            tasks = [dask.delayed(worker, pure=False)() for _ in range(min(workers, len(tiles)))]
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
        _release_memory()


def _do(work: Work, tile: Tile) -> Receipt:
    """Do the work of a tile and tell what became of it."""
    try:
        return Receipt(tile, work(tile))
    except Exception as error:
        return Receipt(tile, error=error, trace=traceback.format_exc())


def _release_memory() -> None:
    """Give back to the system what the heaps of threads that ended keep, where the C library can (glibc)."""
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)
