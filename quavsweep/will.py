"""What is still to be done by a process that ends at once, without taking itself apart."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator

_wills: dict[object, Callable[[], None]] = {}


@contextlib.contextmanager
def will(function: Callable[[], None]) -> Iterator[None]:
    """Have a function called should the process end at once within this context."""
    key = object()
    _wills[key] = function
    try:
        yield
    finally:
        del _wills[key]


def execute(seconds: float) -> None:
    """Call them, the last first, for as long as that may take; from any thread."""

    def call() -> None:
        for function in reversed([*_wills.values()]):
            with contextlib.suppress(Exception):
                function()

    thread = threading.Thread(target=call, name="quavsweep-will", daemon=True)
    thread.start()
    thread.join(seconds)
