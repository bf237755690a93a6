"""What runs on a worker of a cluster."""

from __future__ import annotations

import hashlib
from dataclasses import replace

from distributed import get_worker

from quavsweep.errors import QuavsweepError
from quavsweep.executor.receipt import Receipt, Task, do
from quavsweep.grid import Tile
from quavsweep.kernels.syntax import syntax_digest

TRAVELLING = (  # modules of all that goes to a worker and back
    "quavsweep.errors",
    "quavsweep.executor.receipt",
    "quavsweep.executor.remote",
    "quavsweep.grid",
    "quavsweep.provenance",
    "quavsweep.step_check",
    "quavsweep.store.shard",
    "quavsweep.work",
)
_ABANDONED: set[str] = set()  # tokens of runs that nobody waits for any more


def abandon(token: str) -> None:
    """Stop the tiles of a run on this worker, and those that it may still be given."""
    _ABANDONED.add(token)


def greet() -> str:
    """Return a digest of the code of all that travels, by which both ends know that they understand each other."""
    return hashlib.sha256("".join(map(syntax_digest, TRAVELLING)).encode()).hexdigest()


def do_remotely(task: Task, tile: Tile, token: str) -> Receipt:
    """Do the work of a tile on this worker; of an error that the driver may not know its text travels."""
    receipt = replace(do(lambda: task(lambda: token in _ABANDONED), tile), worker=get_worker().address)
    if receipt.error is None or isinstance(receipt.error, QuavsweepError):
        return receipt
    return replace(receipt, error=RuntimeError(f"{type(receipt.error).__name__}: {receipt.error}"))
