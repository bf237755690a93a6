"""F02: SIGKILL at every step of publishing and consolidating. F03: an error of the system at any step."""

from __future__ import annotations

import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

from tests.faults.arena import Arena
from tests.faults.fault import Case, Fault
from tests.faults.kill import invalid, litter, shard_files
from tests.faults.subject import Subject
from tests.faults.tracer import counted, inject, traced

FAILING = ("write", "fsync", "close", "rename", "openat", "mkdir")
ERRORS = ("EIO", "ENOSPC", "EDQUOT", "EMFILE", "EROFS")
PROMISED = (0, 74, 75)


def _nearly_done(arena: Arena, subject: Subject, place: Path) -> None:
    """Make a run of which two tiles and the result are missing, so that each kind of step is left."""
    run = place / "run"
    shutil.copytree(arena.undisturbed(subject).run, run)
    (run / "result.h5").unlink()
    for number in arena.rng.sample(range(subject.tiles), 2):
        for path in run.glob(f"shards/*/*/*/tile-{number:07d}.*"):
            path.unlink()


def _steps(arena: Arena, subject: Subject) -> list[tuple[str, int]]:
    """Return every step of such a run: a system call, and its number."""
    with arena.place() as place:
        _nearly_done(arena, subject, place)
        victim = arena.start(subject, place, ("--workers", "1"), gated=True)
        most = counted(victim, place / "trace")
    return [(call, number) for call in most for number in range(1, most[call] + 1)]


def _kill_at_steps(arena: Arena, cases: int) -> Iterator[Case]:
    steps = [(subject, *step) for subject in arena.chosen for step in _steps(arena, subject)]
    for subject, call, number in arena.rng.sample(steps, min(cases, len(steps))):
        with arena.place() as place:
            _nearly_done(arena, subject, place)
            victim = arena.start(subject, place, ("--workers", "1"), gated=True)
            with traced(victim, *inject(call, "signal=SIGKILL", str(number))):
                code = victim.wait()
            note = _state(place) or ("" if code in (0, -signal.SIGKILL) else f"ended with {code}: {victim.out[-300:]}")
            note = note or arena.finish(subject, place) or _littered(place)
            note = note and f"{subject.name}, SIGKILL at {call} {number}: {note}"
            yield Case(not note, note, "other bytes" in note, (call, "killed" if code else "done before"))


def _fail_at_steps(arena: Arena, cases: int) -> Iterator[Case]:
    most = {}
    for subject in arena.chosen:
        with arena.place() as place:
            most[subject] = counted(arena.start(subject, place, gated=True), place / "trace")
    for _, subject in zip(range(cases), arena.subjects(), strict=False):
        call, error = arena.rng.choice(FAILING), arena.rng.choice(ERRORS)
        number = arena.rng.randint(1, most[subject][call])
        lasting = arena.rng.choice(("", "+"))
        with arena.place() as place:
            victim = arena.start(subject, place, gated=True)
            with traced(victim, *inject(call, f"error={error}", f"{number}{lasting}")):
                code = victim.wait()
            note = _state(place) or ("" if code in PROMISED else f"ended with {code}: {victim.out[-300:]}")
            if not note and "Traceback" in victim.out:
                note = f"a traceback: {victim.out[-300:]}"
            note = note or arena.finish(subject, place) or _littered(place)
            note = note and f"{subject.name}, {error} at {call} {number}{lasting}: {note}"
            yield Case(not note, note, "other bytes" in note, (call, error, f"exit {code}"))


def _state(place: Path) -> str:
    """Return what is wrong with what lies in the folder, beyond that it is not complete."""
    bad = invalid(shard_files(place / "run"))
    return f"invalid shards are visible: {bad}" if bad else ""


def _littered(place: Path) -> str:
    left = litter(place / "run")
    return f"litter: {left}" if left else ""


FAULTS = (
    Fault("F02", "SIGKILL at each step of publishing and consolidating", 40, 10**6, _kill_at_steps),
    Fault("F03", "an error of the system at any step", 40, 600, _fail_at_steps),
)
