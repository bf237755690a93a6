"""Two drivers in one folder: F14 with a lock, F15 without one."""

from __future__ import annotations

import itertools
import signal
import time
from collections.abc import Iterator
from pathlib import Path

from quavsweep.store import RunFolder
from tests.faults.arena import HANG_SECONDS, Arena, Victim, kill, sha256
from tests.faults.fault import Case, Fault
from tests.faults.kill import invalid, litter, shard_files
from tests.faults.subject import SMALL, SUBJECTS, Subject

SECONDS = 1.0  # within which the second driver is to have been told


def _subjects(cases: int) -> Iterator[Subject]:
    """Yield sweeps, most of them small."""
    return itertools.islice(itertools.cycle((*[SMALL] * 4, *SUBJECTS)), cases)


def _locked(arena: Arena, cases: int) -> Iterator[Case]:
    for subject in _subjects(cases):
        with arena.place() as place:
            yield _second(arena, subject, place)


def _second(arena: Arena, subject: Subject, place: Path) -> Case:
    """Return what becomes of a second driver, and of the first."""
    (second_place := place / "second").mkdir()
    command = ["run", str(arena.config(subject)), "--out", str(place / "run"), "--no-plot"]
    second = arena.command(subject, second_place, command, gated=True)
    second.wait_until_stopped()
    first = _in_the_middle(arena, subject, place)
    begin = time.monotonic()
    second.send(signal.SIGCONT)
    code = second.wait()
    seconds = time.monotonic() - begin
    first.send(signal.SIGCONT)
    if first.wait() != 0:
        note = f"the first ended with {first.code}: {first.out[-300:]}"
    elif sha256(place / "run" / "result.h5") != arena.undisturbed(subject).digest:
        note = "other bytes"
    elif code != 5 or f"process {first.pid} on " not in second.out:
        note = f"the second ended with {code}: {second.out[-300:]}"
    else:
        note = f"the second needed {seconds:.1f} s" if seconds > SECONDS else ""
    return Case(not note, note, silent=note == "other bytes", kinds=(subject.name,))


def _in_the_middle(arena: Arena, subject: Subject, place: Path) -> Victim:
    """Return a driver that is stopped while it holds the folder."""
    seconds = arena.undisturbed(subject).seconds
    while True:
        first = arena.start(subject, place)
        deadline = time.monotonic() + HANG_SECONDS
        while not RunFolder(place / "run").holder and first.code is None and time.monotonic() < deadline:
            time.sleep(0.005)
        first.process.join(arena.rng.uniform(0, seconds / 2))
        first.send(signal.SIGSTOP)
        if first.code is None and RunFolder(place / "run").holder:
            return first
        kill(first)


def _unlocked(arena: Arena, cases: int) -> Iterator[Case]:
    for subject in _subjects(cases):
        with arena.place() as place:
            yield _both(arena, subject, place)


def _both(arena: Arena, subject: Subject, place: Path) -> Case:
    """Return what becomes of two drivers at once, the second a little later."""
    run = place / "run"
    command = ["run", str(arena.config(subject)), "--out", str(run), "--no-plot", "--no-lock"]
    drivers = []
    for name in ("first", "second"):
        (place / name).mkdir()
        drivers.append(arena.command(subject, place / name, command, gated=True))
    for driver in drivers:
        driver.wait_until_stopped()
    for driver in drivers:
        driver.send(signal.SIGCONT)
        time.sleep(arena.rng.choice([0, arena.rng.uniform(0, arena.undisturbed(subject).seconds)]))
    codes = [driver.wait() for driver in drivers]
    bad = invalid(shard_files(run))
    if codes != [0, 0]:
        note = f"they ended with {codes}: {drivers[0].out[-300:]} {drivers[1].out[-300:]}"
    elif sha256(run / "result.h5") != arena.undisturbed(subject).digest:
        note = "other bytes"
    else:
        note = f"invalid shards are visible: {bad}" if bad else f"litter: {litter(run)}" if litter(run) else ""
    return Case(not note, note, silent=note == "other bytes" or bool(bad), kinds=(subject.name,))


FAULTS = (
    Fault("F14", "two drivers, one folder: the second is told who holds it", 5, 50, _locked),
    Fault("F15", "two drivers, one folder, no lock", 5, 50, _unlocked),
)
