"""Where faults are made: folders, processes under attack, and what an undisturbed run gives."""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import multiprocessing
import os
import random
import shutil
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from tests.faults.probe import Probe
from tests.faults.subject import SUBJECTS, Subject

HANG_SECONDS = 120.0

Prepare = Callable[[], None]


def sha256(path: Path) -> str:
    """Return the digest of a file, empty if there is none."""
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


@cache
def _server() -> Any:
    """Return the context of the server from which processes under attack are forked."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tests.faults.victim"])
    return context


def _attend(*arguments: Any) -> None:
    from tests.faults.victim import attend  # noqa: PLC0415 # only in the server, where it is loaded already

    attend(*arguments)


@dataclass
class Victim:
    """A process under attack."""

    process: Any
    folder: Path
    begun: float = field(default_factory=time.monotonic)

    @property
    def pid(self) -> int:
        """Its number."""
        return int(self.process.pid)

    @property
    def code(self) -> int | None:
        """Its exit code, negative after a signal, None while it lives."""
        code = self.process.exitcode
        return None if code is None else int(code)

    @property
    def out(self) -> str:
        """What it printed."""
        path = self.folder / "out"
        return path.read_text(errors="replace") if path.exists() else ""

    def send(self, number: int) -> None:
        """Send it a signal, if it lives."""
        with contextlib.suppress(ProcessLookupError):  # it may end at any time
            if self.code is None:
                os.kill(self.pid, number)

    def wait(self, seconds: float = HANG_SECONDS) -> int | None:
        """Wait for its end and return the exit code; None if it hangs, and it is killed then."""
        self.process.join(seconds)
        code = self.code
        if code is None:
            self.process.kill()
            self.process.join()
        return code

    def wait_until_stopped(self) -> None:
        """Wait until it has stopped itself at its gate."""
        status = Path(f"/proc/{self.pid}/stat")
        while status.read_text().rpartition(")")[2].split()[0] != "T":
            time.sleep(0.002)


@dataclass(frozen=True)
class Undisturbed:
    """A run that nobody disturbed: its folder, the SHA-256 of its result, its time, the stages of tiles it began."""

    run: Path
    digest: str
    seconds: float
    begun: int


@dataclass
class Arena:
    """Where faults are made.

    Parameters
    ----------
    folder : Path
        An empty one, for everything.
    rng : Random
    """

    folder: Path
    rng: random.Random
    _numbers: Iterator[int] = field(default_factory=itertools.count)
    _undisturbed: dict[str, Undisturbed] = field(default_factory=dict)

    @property
    def chosen(self) -> tuple[Subject, ...]:
        """The sweeps under attack."""
        return SUBJECTS

    def subjects(self) -> Iterator[Subject]:
        """Yield the sweeps under attack in turn, without end."""
        return itertools.cycle(SUBJECTS)

    @contextlib.contextmanager
    def place(self) -> Iterator[Path]:
        """Give an empty folder for a case, which is gone afterwards."""
        path = self.folder / f"case-{next(self._numbers)}"
        path.mkdir()
        try:
            yield path
        finally:
            shutil.rmtree(path, ignore_errors=True)

    def undisturbed(self, subject: Subject) -> Undisturbed:
        """Return what a run gives that nobody disturbs; its folder is not to be changed."""
        if subject.name not in self._undisturbed:
            for attempt in ("cold", "warm"):
                place = self.folder / f"undisturbed-{subject.name}-{attempt}"
                place.mkdir()
                begin = time.monotonic()
                victim = self.start(subject, place)
                if victim.wait() != 0:
                    raise RuntimeError(f"the sweep cannot be run: {victim.out}")
                seconds = time.monotonic() - begin
            run = place / "run"
            digest, begun = sha256(run / "result.h5"), Probe(place / "probe")["begun"]
            self._undisturbed[subject.name] = Undisturbed(run, digest, seconds, begun)
        return self._undisturbed[subject.name]

    def config(self, subject: Subject) -> Path:
        """Return a file with the config of a sweep."""
        path = self.folder / f"{subject.name}.yaml"
        if not path.exists():
            path.write_text(subject.text)
        return path

    def start(
        self,
        subject: Subject,
        place: Path,
        arguments: Sequence[str] = (),
        *,
        gated: bool = False,
        prepare: Prepare | None = None,
    ) -> Victim:
        """Start `quavsweep run` of a sweep into `place/run`, in small tiles in a new random order.

        Parameters
        ----------
        gated : bool
            Whether the process stops itself before it begins, until SIGCONT.
        prepare : callable
            Called in the process before it begins; a function of a module, or a partial one.
        """
        Probe(place / "probe").begin()
        command = ["run", str(self.config(subject)), "--out", str(place / "run"), "--no-plot", *arguments]
        return self.command(subject, place, command, gated=gated, prepare=prepare)

    def command(
        self,
        subject: Subject,
        place: Path,
        command: Sequence[str],
        *,
        gated: bool = False,
        prepare: Prepare | None = None,
    ) -> Victim:
        """Start a command of quavsweep, as `start` does."""
        arguments = (subject, list(command), place, self.rng.getrandbits(32), gated, prepare)
        process = _server().Process(target=_attend, args=arguments, daemon=True)
        process.start()
        return Victim(process, place)

    def finish(self, subject: Subject, place: Path) -> str:
        """Run what is left in `place/run`; return what is wrong with the end, empty if it equals the undisturbed."""
        victim = self.start(subject, place)
        code = victim.wait()
        if code != 0:
            return f"resuming ended with {code}: {victim.out[-300:]}"
        return "" if sha256(place / "run" / "result.h5") == self.undisturbed(subject).digest else "other bytes"


def kill(victim: Victim) -> None:
    """Kill a process as no handler can see."""
    victim.send(signal.SIGKILL)
    victim.wait()
