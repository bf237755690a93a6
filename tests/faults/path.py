"""F33: folders and files that are not there, not what they should be, not writable, or oddly named."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tests.faults.arena import Arena, Victim, sha256
from tests.faults.fault import Case, Fault
from tests.faults.read_only import read_only
from tests.faults.subject import SMALL

Make = Callable[[Path], object]


@dataclass(frozen=True)
class Odd:
    """An odd path: how it is made in an empty folder, the command, and its possible exit codes.

    In words of the command RUN stands for the folder of a finished run and CONFIG for the sweep's config.
    """

    name: str
    words: Sequence[str]
    codes: tuple[int, ...]
    make: Make = lambda place: None
    writable: bool = True


def _loop(place: Path) -> None:
    (place / "loop").symlink_to("loop")


def _file(place: Path) -> None:
    (place / "file").write_text("no folder\n")


def _instead(name: str) -> Make:
    """Return what puts a folder in the place of a file of the run, and a file in that of a folder."""

    def make(place: Path) -> None:
        path = place / "run" / name
        if path.is_dir():
            shutil.rmtree(path)
            path.write_text("no folder\n")
        else:
            path.unlink(missing_ok=True)
            path.mkdir()

    return make


def _gone(place: Path) -> None:
    (place / "gone").mkdir()
    os.chdir(place / "gone")
    (place / "gone").rmdir()


def _out(name: str, *codes: int, make: Make = lambda place: None, label: str = "") -> Odd:
    return Odd(label or f"--out {name!r}", ("run", "CONFIG", f"--out={name}", "--no-plot"), codes, make)


LONG = "x" * 255
ODDS = (
    _out("a/b/c/d", 0, label="missing parents"),
    _out("file", 2, make=_file, label="a file for a folder"),
    _out("file/run", 2, make=_file, label="a file for a parent"),
    _out("loop", 2, 74, make=_loop, label="a link to itself"),
    _out("loop/run", 2, 74, make=_loop, label="under a link to itself"),
    _out("nowhere", 0, 2, make=lambda place: (place / "nowhere").symlink_to("missing"), label="a link to nowhere"),
    _out("with a blank", 0),
    _out("Ωmega µ 飛行", 0),
    _out("two\nlines", 0),
    _out("-dash", 0),
    _out("'quoted' \"twice\" $HOME `id` *", 0),
    _out("\x1b[31mred", 0),
    _out("not \udcff utf-8", 0),
    _out(LONG, 0, label="the longest name"),
    _out(LONG + "x", 74, label="too long a name"),
    _out("/".join(["x" * 200] * 30), 0, 74, label="too long a path"),
    _out("x" * 100_000, 2, 74, label="a name without end"),
    _out("/dev/null/run", 2, label="under a device"),
    _out("/dev/null", 2, label="a device"),
    _out("/proc/run", 74, label="where nothing can be made"),
    Odd("a config that is a link to itself", ("run", "loop"), (2,), _loop),
    Odd("a config that is a folder", ("run", "."), (2,)),
    Odd("a config without end", ("run", "/dev/zero"), (2,)),
    Odd("a config that is not there", ("run", "not \udcff there\n.yaml"), (2,)),
    *(
        Odd(f"{name} is of the other sort", ("run", "CONFIG", "--out=run", "--no-plot"), codes, _instead(name))
        for name, codes in (
            ("result.h5", (0,)),
            ("run.json", (0,)),
            ("config.yaml", (4,)),
            ("lock", (2, 74)),
            ("shards", (74,)),
        )
    ),
    Odd("a figure that is a folder", ("plot", "RUN", "--out=."), (2, 74)),
    Odd("a figure where there is no folder", ("plot", "RUN", "--out=none/map.png"), (0, 2, 74)),
    Odd("a figure with an odd name", ("plot", "RUN", "--out=not \udcff\n.png"), (0,)),
    Odd("a table that is a folder", ("export", "RUN", "--csv", "region", "--out=."), (2, 74)),
    Odd("a table where there is no folder", ("export", "RUN", "--csv", "region", "--out=none/x.csv"), (2, 74)),
    Odd("a netCDF where there is no folder", ("export", "RUN", "--nc", "region", "--out=none/x.nc"), (0, 2, 74)),
    Odd("a template where there is no folder", ("init", "--out=none/x.yaml"), (2, 74)),
    Odd("a template over a link to itself", ("init", "--out=loop"), (2, 74), _loop),
    Odd("a file for a run", ("status", "file"), (2,), _file),
    Odd("a link to itself for a run", ("verify", "loop"), (2, 74), _loop),
    Odd("the working folder is gone", ("run", "CONFIG", "--no-plot"), (2, 74), _gone),
    Odd("the working folder is gone, a figure", ("plot", "RUN", "--out=x.png"), (2, 74), _gone),
    Odd("read-only: a new run", ("run", "CONFIG", "--out=new", "--no-plot"), (74,), writable=False),
    Odd("read-only: a finished run", ("run", "CONFIG", "--out=run", "--no-plot"), (0, 74), writable=False),
    Odd("read-only: status", ("status", "run"), (0,), writable=False),
    Odd("read-only: verify", ("verify", "run"), (0,), writable=False),
    Odd("read-only: plot", ("plot", "run"), (74,), writable=False),
    Odd("read-only: classify", ("classify", "run", "--no-plot"), (74,), writable=False),
    Odd("read-only: extend", ("extend", "run", "--duration=12", "--no-plot"), (74,), writable=False),
    Odd("read-only: table", ("export", "run", "--csv", "region"), (74,), writable=False),
    Odd("read-only: netCDF", ("export", "run", "--nc", "region"), (74,), writable=False),
    Odd("read-only: template", ("init",), (74,), writable=False),
)


def arrive(place: Path, number: int) -> None:
    """Go where a command is to be carried out, and make what it will find."""
    os.chdir(place)
    ODDS[number].make(place)


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    every = range(len(ODDS))
    numbers = [number % len(ODDS) for number in range(cases)] if cases > len(ODDS) else arena.rng.sample(every, cases)
    # The last ones cannot be made everywhere, and nothing is made after what cannot.
    for number in sorted(numbers, key=lambda number: not ODDS[number].writable):
        odd = ODDS[number]
        with arena.place() as place, contextlib.ExitStack() as stack:
            (here := place / "here").mkdir()
            if "run" in (words := [word.removeprefix("--out=") for word in odd.words[1:]]):
                shutil.copytree(arena.undisturbed(SMALL).run, here / "run")
            if not odd.writable:
                stack.enter_context(read_only(here))
            known = {"CONFIG": str(arena.config(SMALL)), "RUN": str(arena.undisturbed(SMALL).run)}
            command = [known.get(word, word) for word in odd.words]
            victim = arena.command(SMALL, place, command, prepare=partial(arrive, here, number))
            victim.wait()
            result = here / words[1] / "result.h5" if victim.code == 0 and words[0] == "CONFIG" else None
            note = _wrong(odd, victim) or _other(result, arena)
            yield Case(not note, f"{odd.name}: {note}" if note else "", note == "other bytes", (f"exit {victim.code}",))


def _wrong(odd: Odd, victim: Victim) -> str:
    """Return what is wrong with how a command ended: its code, or what it said."""
    sentences = [line for line in victim.out.splitlines() if line.startswith("quavsweep: ")]
    told = len(sentences) == 1 and len(victim.out.splitlines()) == 1 if victim.code else bool(victim.out)
    if victim.code in odd.codes and told and "Traceback" not in victim.out:
        return ""
    return f"exit {victim.code}, {victim.out[-500:] or 'without a word'}"


def _other(result: Path | None, arena: Arena) -> str:
    """Return what is wrong with a result, if there has to be one."""
    return "" if result is None or sha256(result) == arena.undisturbed(SMALL).digest else "other bytes"


FAULTS = (Fault("F33", "folders and files that are missing, read-only, odd", 12, 2 * len(ODDS), _attack),)
