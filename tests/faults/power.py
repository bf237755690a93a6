"""A disk that loses power at a chosen step: what was not synced is lost, and nothing tidies up."""

from __future__ import annotations

import os
import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

STEPS = ("fsync", "fchmod", "replace", "rename", "unlink", "mkdir")


class PowerLossError(BaseException):
    """The end of a process that no handler may see."""


@dataclass
class Disk:
    """What a process does to files, until it ends at a step.

    Parameters
    ----------
    steps : int
        How many steps it lives.
    """

    steps: int
    _synced: set[str] = field(default_factory=set)
    _loose: set[Path] = field(default_factory=set)
    _renamed: list[tuple[Path, Path, bytes | None]] = field(default_factory=list)

    @contextmanager
    def power(self) -> Iterator[None]:
        """Let everything inside meet this disk; it ends early if the power goes, else nothing happens."""
        real = {name: getattr(os, name) for name in STEPS}
        with mock.patch.dict(vars(os), {name: self._step(name, real[name]) for name in STEPS}):
            yield

    def _step(self, name: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def step(*arguments: Any, **options: Any) -> Any:
            self.steps -= 1
            if self.steps < 0:
                raise PowerLossError
            self._note(name, *arguments)
            return real(*arguments, **options)

        return step

    def _note(self, name: str, *arguments: Any) -> None:
        """Remember what a loss of power would undo."""
        if name == "fsync":
            path = os.readlink(f"/proc/self/fd/{arguments[0]}")
            self._synced.add(path)
            self._renamed = [entry for entry in self._renamed if str(entry[1].parent) != path]
        elif name in ("replace", "rename"):
            old, new = Path(arguments[0]).absolute(), Path(arguments[1]).absolute()
            replaced = new.read_bytes() if new.is_file() else None
            self._renamed.append((old, new, replaced))
            (self._loose.discard if str(old) in self._synced else self._loose.add)(new)

    def lose(self, folder: Path, rng: random.Random) -> None:
        """Undo what no sync has made to last: renames, and what is in files that were never synced."""
        for old, new, replaced in reversed(self._renamed):
            if rng.random() < 0.5 and new.is_file():
                new.rename(old)
                if replaced is not None:
                    new.write_bytes(replaced)
        for path in folder.rglob(".quavsweep-*"):
            if str(path.absolute()) not in self._synced:
                data = path.read_bytes()
                path.write_bytes(data[: rng.randint(0, len(data))])
        for path in self._loose:
            if path.is_file():
                path.write_bytes(path.read_bytes()[: rng.randint(0, path.stat().st_size)])
