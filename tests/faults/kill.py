"""F01: SIGKILL at any time, and again while the run is resumed, until it is done."""

from __future__ import annotations

import hashlib
import signal
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from quavsweep.whole import TEMPORARY
from tests.faults.arena import Arena, kill
from tests.faults.fault import Case, Fault
from tests.faults.probe import Probe
from tests.faults.subject import Subject

WORKERS = 2


def shard_files(run: Path) -> set[Path]:
    """Return the shards that lie in a run's folder."""
    return set(run.glob("shards/*/*/*/tile-*.h5"))


def invalid(files: set[Path]) -> list[str]:
    """Return the names of shards that are not what their names tell."""
    bad = []
    for path in files:
        *_, size, sha256, _ = path.name.split(".")
        data = path.read_bytes()
        if len(data) != int(size) or hashlib.sha256(data).hexdigest() != sha256:
            bad.append(path.name)
    return bad


def litter(run: Path) -> list[str]:
    """Return the names of files in the making that lie in a run's folder."""
    return [path.name for path in run.rglob(f"{TEMPORARY}*")]


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    done = 0
    for subject in arena.subjects():
        for case in _history(arena, subject):
            yield case
            done += 1
            if done == cases:
                return


def _history(arena: Arena, subject: Subject) -> Iterator[Case]:
    """Yield a case for each kill of a run, until it is done; the last of them tells how it ended."""
    with arena.place() as place:
        whole, kills, before = arena.undisturbed(subject), 0, set[Path]()
        pending: Case | None = None
        while True:
            victim = arena.start(subject, place, ("--workers", str(WORKERS)))
            victim.process.join(arena.rng.uniform(0.1, whole.seconds * (1.1 - 0.1 * len(before) / whole.begun)))
            kill(victim)
            if victim.code != -signal.SIGKILL:  # it had ended
                break
            kills += 1
            if pending is not None:
                yield pending
            files = shard_files(place / "run")
            bad, lost = invalid(files), before - files
            before = files
            note = f"invalid shards are visible: {bad}" if bad else f"shards were lost: {lost}" if lost else ""
            pending = Case(not note, note, silent=bool(bad), kinds=Probe(place / "probe").kinds)
        if pending is None:
            return
        note = pending.note or _end(arena, subject, place, kills)
        yield Case(not note, note, silent="other bytes" in note, kinds=pending.kinds)


def _end(arena: Arena, subject: Subject, place: Path, kills: int) -> str:
    """Return what is wrong with a run that was resumed until done."""
    note = arena.finish(subject, place)
    if note:
        return note
    if left := litter(place / "run"):
        return f"litter: {left}"
    begun, most = Probe(place / "probe")["begun"], arena.undisturbed(subject).begun + kills * WORKERS
    return "" if begun <= most else f"{begun} stages of tiles were integrated, {most} should do"


def _whole(kinds: Counter[str], cases: int) -> str:
    """Return what is wrong with the phases that were hit."""
    flight, writing = kinds["tile in flight"], kinds["publishing"] + kinds["consolidating"]
    if cases >= 200 and (flight < 0.6 * cases or writing < 0.1 * cases):
        return f"{flight} of {cases} kills hit a tile in flight, {writing} publishing or consolidating"
    return ""


FAULTS = (Fault("F01", "SIGKILL at any time, resumed until done", 60, 1000, _attack, _whole),)
