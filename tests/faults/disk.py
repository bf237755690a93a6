"""F05: a disk that fills up while a run writes to it, and is made larger then."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.faults.arena import Arena
from tests.faults.fault import Case, Fault, NotRunError
from tests.faults.kill import invalid, litter, shard_files
from tests.faults.subject import Subject

KIB = 1024
SMALLEST, LARGEST = 64, 2048  # KiB; no larger than what the run needs
PAGE = 4  # KiB
ENOUGH = 64 * KIB  # KiB


@contextmanager
def disk(path: Path, kib: int) -> Iterator[None]:
    """Mount a disk in memory of that size.

    Raises
    ------
    NotRunError
        If that is not allowed.
    """
    path.mkdir()
    _mount("-t", "tmpfs", "-o", f"size={kib}k", "tmpfs", str(path))
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(path)], check=False, capture_output=True)


def _mount(*arguments: str) -> None:
    try:
        subprocess.run(["mount", *arguments], check=True, capture_output=True, text=True)
    except OSError as error:
        raise NotRunError("there is no mount") from error
    except subprocess.CalledProcessError as error:
        raise NotRunError(f"a disk in memory cannot be mounted: {error.stderr.strip()}") from error


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    """Yield a case for each size, spread evenly in their logarithm and moved a little at random."""
    for number, subject in zip(range(cases), arena.subjects(), strict=False):
        share, largest = (number + arena.rng.random()) / cases, min(LARGEST, _needed(arena, subject) - PAGE)
        yield _filled(arena, subject, round(SMALLEST * (largest / SMALLEST) ** share))


def _needed(arena: Arena, subject: Subject) -> int:
    """Return what a run takes on such a disk [KiB], in whole pages."""
    files = (path for path in arena.undisturbed(subject).run.rglob("*") if path.is_file())
    return sum(-(-path.stat().st_size // (PAGE * KIB)) * PAGE for path in files)


def _filled(arena: Arena, subject: Subject, kib: int) -> Case:
    with arena.place() as place, disk(place / "disk", kib):
        (place / "disk" / "run").mkdir()
        (place / "run").symlink_to(place / "disk" / "run")
        victim = arena.start(subject, place)
        code = victim.wait()
        bad, shards = invalid(shard_files(place / "run")), len(shard_files(place / "run"))
        note = f"invalid shards are visible: {bad}" if bad else ""
        if code != 74 or "Traceback" in victim.out:
            note = f"ended with {code}: {victim.out[-300:]}"
        _mount("-o", f"remount,size={ENOUGH}k", str(place / "disk"))
        note = note or arena.finish(subject, place) or (litter(place / "run") and "litter") or ""
        kind = "with shards" if shards else "without a shard"
        return Case(not note, note and f"{subject.name}, {kib} KiB: {note}", "other bytes" in note, (kind,))


FAULTS = (Fault("F05", "a full disk, made larger then", 8, 64, _attack),)
