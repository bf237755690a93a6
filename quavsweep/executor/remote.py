"""What runs on a worker of a cluster."""

from __future__ import annotations

from dataclasses import replace

from distributed import get_worker

from quavsweep.executor.receipt import Receipt, Task, do
from quavsweep.grid import Tile

_ABANDONED: set[str] = set()  # tokens of runs that nobody waits for any more


def abandon(token: str) -> None:
    """Stop the tiles of a run on this worker, and those that it may still be given."""
    _ABANDONED.add(token)


def do_remotely(task: Task, tile: Tile, token: str) -> Receipt:
    """Do the work of a tile on this worker."""
    return replace(do(lambda: task(lambda: token in _ABANDONED), tile), worker=get_worker().address)
