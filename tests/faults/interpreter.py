"""A process under attack that is an interpreter of its own: `python -m quavsweep`, with or without a kernel cache."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.faults.arena import Arena, Victim
from tests.faults.probe import Probe
from tests.faults.subject import Subject

# SIGHUP does what it does also where these attacks were started by nohup.
HEARING = ("env", "--default-signal=HUP")


class Interpreter:
    """A process with the interface of those of `multiprocessing`."""

    def __init__(self, words: Sequence[str], out: Path, variables: dict[str, str]) -> None:
        with out.open("wb") as file:
            command = [*HEARING, sys.executable, "-m", *words]
            self._process = subprocess.Popen(command, stdout=file, stderr=file, env={**os.environ, **variables})
        self.pid, self.kill = self._process.pid, self._process.kill

    @property
    def exitcode(self) -> int | None:
        """Its exit code, None while it lives."""
        return self._process.poll()

    def join(self, seconds: float | None = None) -> None:
        """Wait for its end, at most so long."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)


def run_fresh(arena: Arena, subject: Subject, place: Path, arguments: Sequence[str], *, cold: bool) -> Victim:
    """Start `quavsweep run` of a sweep into `place/run`; `cold` with no kernel compiled."""
    Probe(place / "probe").begin()
    words = ["quavsweep", "run", str(arena.config(subject)), "--out", str(place / "run"), "--no-plot", *arguments]
    cache = {"QUAVSWEEP_CACHE": str(place / f"cache-{arena.rng.getrandbits(32)}")} if cold else {}
    return Victim(Interpreter(words, place / "out", cache), place)
