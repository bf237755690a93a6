"""What a process under attack is doing, told through memory that outlives it."""

from __future__ import annotations

import mmap
import threading
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

NAMES = ("begun", "integrating", "publishing", "consolidating", "checking", "going on")


class Probe:
    """Counts what a process has begun, and what it is doing now, in a file that both sides map."""

    def __init__(self, path: Path) -> None:
        if not path.exists():
            path.write_bytes(bytes(8 * len(NAMES)))
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), 0)
        self._counts = np.frombuffer(self._memory, dtype=np.int64)
        self._lock = threading.Lock()

    def __getitem__(self, name: str) -> int:
        """Return a count."""
        return int(self._counts[NAMES.index(name)])

    def begin(self) -> None:
        """Forget what a process that was killed was doing; what it has begun stays."""
        self._counts[1:] = 0

    def _add(self, number: int, name: str) -> None:
        with self._lock:
            self._counts[NAMES.index(name)] += number

    def around(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that is counted as long as it runs."""

        @wraps(function)
        def counted(*arguments: Any, **options: Any) -> Any:
            self._add(1, name)
            if name == "integrating":
                self._add(1, "begun")
            try:
                return function(*arguments, **options)
            finally:
                self._add(-1, name)

        return counted

    @property
    def kinds(self) -> tuple[str, ...]:
        """What the process was doing when it ended."""
        flight = ("tile in flight",) if self["integrating"] or self["publishing"] else ()
        doing = tuple(name for name in ("publishing", "consolidating") if self[name])
        return (*flight, *doing) or ("neither",)
