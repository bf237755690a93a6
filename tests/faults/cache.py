"""F29: the kernel cache is read-only, absent, damaged, or others can write there."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from quavsweep.kernels import cache, compiler
from tests.faults.arena import Arena, sha256
from tests.faults.fault import Case, Fault
from tests.faults.read_only import read_only
from tests.faults.subject import SMALL

Harm = Callable[[Arena, Path], None]


def use_cache(folder: Path) -> None:
    """Use another cache than the process was started with, and nothing that is loaded already."""
    os.environ["QUAVSWEEP_CACHE"] = str(folder)
    cache.cache_folder.cache_clear()
    compiler._load.cache_clear()


def _bits(suffix: str) -> Harm:
    """Return what flips a bit in a file of the cache with that suffix."""

    def harm(arena: Arena, folder: Path) -> None:
        path = arena.rng.choice(sorted(folder.rglob(f"*{suffix}")))
        data = bytearray(path.read_bytes())
        data[arena.rng.randrange(len(data))] ^= 1 << arena.rng.randrange(8)
        path.write_bytes(data)

    return harm


def _cut(arena: Arena, folder: Path) -> None:
    for path in (path for path in folder.rglob("*") if path.is_file()):
        os.truncate(path, arena.rng.randrange(path.stat().st_size))


def _swapped(arena: Arena, folder: Path) -> None:
    """Give each kernel the machine code of another one."""
    paths = sorted(folder.rglob("*.nbc"))
    texts = [path.read_bytes() for path in paths]
    for path, text in zip(paths, texts[1:] + texts[:1], strict=True):
        path.write_bytes(text)


def _open_to_all(arena: Arena, folder: Path) -> None:
    _cut(arena, folder)  # nothing of it may be loaded
    folder.chmod(0o777)


def _absent(arena: Arena, folder: Path) -> None:
    shutil.rmtree(folder)


def _a_file(arena: Arena, folder: Path) -> None:
    _absent(arena, folder)
    folder.write_text("no folder\n")


HARMS: dict[str, Harm] = {
    "bit of machine code": _bits(".nbc"),
    "bit of an index": _bits(".nbi"),
    "bit of a program": _bits(".json"),
    "bit of a source": _bits(".py"),
    "bit of a seal": _bits(".seal"),
    "cut": _cut,
    "machine code swapped": _swapped,
    "world-writable": _open_to_all,
    "absent": _absent,
    "a file in its place": _a_file,
}
UNWRITABLE = Path("/proc/quavsweep/cache")  # where even root can make nothing


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    with arena.place() as place:
        good = place / "good"
        if arena.start(SMALL, place, prepare=partial(use_cache, good)).wait() != 0:
            raise RuntimeError("the cache cannot be filled")
        # What is damaged costs least time, because only that is compiled again.
        names = ["bit of machine code", "bit of a program", "machine code swapped", "unwritable", *HARMS, "read-only"]
        for number in range(cases):
            name = names[number % len(names)]
            with arena.place() as case:
                yield _case(arena, name, case, good)


def _case(arena: Arena, name: str, place: Path, good: Path) -> Case:
    """Return what a run makes of a cache that was harmed."""
    folder = UNWRITABLE
    if name != "unwritable":
        shutil.copytree(good, folder := place / "cache")
    if name in HARMS:
        HARMS[name](arena, folder)
    with read_only(folder) if name == "read-only" else contextlib.nullcontext():
        victim = arena.start(SMALL, place, prepare=partial(use_cache, folder))
        code = victim.wait()
    refused = code in (2, 74) and "Traceback" not in victim.out
    wrong = code == 0 and sha256(place / "run" / "result.h5") != arena.undisturbed(SMALL).digest
    note = "other bytes" if wrong else "" if code == 0 or refused else f"exit {code}, {victim.out[-300:]}"
    return Case(not note, f"{name}: {note}" if note else "", silent=wrong, kinds=(name,))


FAULTS = (Fault("F29", "the kernel cache is damaged, absent, or not to be trusted", 6, 40, _attack),)
