"""Receipts: what became of a tile, and what an executor is."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from quavsweep.errors import DiskError, IdentityError, StoppedError
from quavsweep.grid import Tile

Stopped = Callable[[], bool]
Task = Callable[[Stopped], Any]  # does the work of a tile, asks now and then whether to stop, returns something small
TaskOf = Callable[[Tile], Task]  # asked just before a tile is begun


@dataclass(frozen=True)
class Receipt:
    """What became of a tile: what the work returned, or the error that it raised.

    `fatal` tells an error that ends the run (a stop, a full disk) from one that concerns this tile alone; `worker` is
    the address of a worker on a cluster.
    """

    tile: Tile
    outcome: Any = None
    error: BaseException | None = None
    trace: str = ""
    worker: str = ""

    @property
    def fatal(self) -> bool:
        """Whether the run cannot go on."""
        return isinstance(self.error, StoppedError | DiskError | IdentityError)

    @property
    def error_line(self) -> str:
        """The error, with its type, in a line."""
        return " ".join("".join(traceback.format_exception_only(self.error)).split())[:1000]


class Executor(Protocol):
    """Runs the work of tiles somewhere."""

    def run(self, task_of: TaskOf, tiles: Sequence[Tile], stop: threading.Event) -> Iterator[Receipt]:
        """Yield a receipt for each tile, as they come; one whose error is a `StoppedError` once `stop` is set."""


def do(task: Callable[[], Any], tile: Tile) -> Receipt:
    """Do the work of a tile and tell what became of it."""
    try:
        return Receipt(tile, task())
    except Exception as error:
        return Receipt(tile, error=error, trace=traceback.format_exc())
