"""Runs tiles on threads with dask and yields their receipts as they come; the only place that imports dask."""

from __future__ import annotations

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
        In no promised order.
    workers : int
        Number of threads.
    """
    receipts: queue.Queue[Receipt | BaseException | None] = queue.Queue()
    if not tiles:
        return
    abandoned = threading.Event()

    def task(tile: Tile) -> None:
        if abandoned.is_set():
            return
        try:
            receipts.put(Receipt(tile, work(tile)))
        except Exception as error:
            receipts.put(Receipt(tile, error=error, trace=traceback.format_exc()))

    def drive() -> None:
        try:
            jobs = [dask.delayed(task, pure=False)(tile, dask_key_name=f"tile-{n:09d}") for n, tile in enumerate(tiles)]
            dask.compute(*jobs, scheduler="threads", num_workers=workers)
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
