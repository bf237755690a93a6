"""All faults, in the order of their keys."""

from __future__ import annotations

from collections.abc import Sequence

from tests.faults import (
    bomb,
    cache,
    cell,
    config,
    disk,
    edit,
    flip,
    growth,
    identity,
    kill,
    layout,
    leak,
    lock,
    machine,
    path,
    step,
    stop,
    stranger,
    terminal,
    untrusted,
    worker,
)
from tests.faults.fault import Fault

MODULES = (
    *(bomb, cache, cell, config, disk, edit, flip, growth, identity, kill, layout),
    *(leak, lock, machine, path, step, stop, stranger, terminal, untrusted, worker),
)
FAULTS: tuple[Fault, ...] = tuple(sorted((f for module in MODULES for f in module.FAULTS), key=lambda f: f.key))


def select(keys: Sequence[str]) -> list[Fault]:
    """Return faults by key, all if none is given.

    Raises
    ------
    KeyError
        With the first key that is none.
    """
    known = {fault.key for fault in FAULTS}
    for key in keys:
        if key not in known:
            raise KeyError(key)
    return [fault for fault in FAULTS if not keys or fault.key in keys]


def listing() -> str:
    """Return the faults, one a line."""
    return "\n".join(f"  {f.key:5} {f.push:>5} {f.demand:>7,}  {f.title}" for f in FAULTS)
