"""F32: YAML that is a bomb, and YAML whose words are easily misread: refused, or read as documented."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from quavsweep.config import Sweep, load_sweep
from tests.faults.arena import Arena
from tests.faults.config import Command
from tests.faults.fault import Case, Fault
from tests.faults.subject import SMALL

SIZE = 2**20  # bytes that a config may have
MEMORY = 2**31  # bytes of address space
SECONDS = 100.0  # for a text of that size; some machines are slow, and others busy
BASE = SMALL.text
LAUGHS = "a0: &a0 [x, x]\n" + "".join(f"a{i + 1}: &a{i + 1} [*a{i}, *a{i}]\n" for i in range(60))


@dataclass(frozen=True)
class Bomb:
    """A text that would take too much, and what is said of it; `fill` times `SIZE` bytes of zeros follow."""

    name: str
    text: Callable[[], str]
    says: str
    fill: int = 0


def _full(unit: str, before: str = "", after: str = "") -> Callable[[], str]:
    """Return what makes a text as large as a config may be."""
    return lambda: before + unit * ((SIZE - len(before) - len(after)) // len(unit)) + after


BOMBS = (
    Bomb("a billion laughs", lambda: LAUGHS, "1: a0: anchors and aliases are not allowed"),
    Bomb("quadratic laughs", lambda: f"a: &a {'x' * 500_000}\nb: [{'*a,' * 100_000}]", "1: a: anchors and aliases"),
    Bomb("100 MB of nothing", lambda: BASE, "is larger than", 100),
    Bomb("10 GB of nothing", lambda: "", "is larger than", 10_000),
    Bomb("lists in lists", _full("["), "nested deeper than 20"),
    Bomb("mappings in mappings", _full("{a: "), "nested deeper than 20"),
    Bomb("lists in lists, block style", _full("- "), "nested deeper than 20"),
    Bomb("keys of keys", _full("? "), "a key here is a list or a mapping"),
    Bomb("indented ever more", lambda: "".join(" " * i + "a:\n" for i in range(1400)), "nested deeper than 20"),
    Bomb("a key without end", _full("k", after=": 1"), "which is too long"),
    Bomb("a word without end", _full("x", "name: "), "which is too long"),
    Bomb("escapes without end", _full("\\u0041", 'name: "', '"'), "which is too long"),
    Bomb("a quotation without end", _full("x", "name: '"), "its quotation mark is not closed"),
    Bomb("a number without end", _full("9", BASE + "stop_early: "), "which is too long"),
    Bomb("comments", _full("#\n"), "is not a mapping of keys"),
    Bomb("empty lines", _full("\n"), "is not a mapping of keys"),
    Bomb("blanks", _full(" "), "is not a mapping of keys"),
    Bomb("zeros", _full("\0"), "U+0000 is not allowed"),
    Bomb("directives", _full("%a\n"), "does not belong here"),
    Bomb("documents", _full("---\n"), "a second document begins here"),
    Bomb("tags", _full("!a "), "tags are not allowed"),
    Bomb("a key twice", _full("a: 1\n"), "2: a: duplicate key"),
    Bomb("40,000 keys", lambda: "".join(f"k{i}: 1\n" for i in range(40_000)), "1: k0: unknown key"),
    Bomb("a list of 100,000", lambda: f"{BASE}stop_early: [{'1,' * 100_000}]", "stop_early: a list is not accepted"),
)


@dataclass(frozen=True)
class Word:
    """A change of a config, and what becomes of it: what is said, or a value that is read."""

    old: str
    new: str
    says: str = ""
    read: Callable[[Sweep], bool] = lambda sweep: False


def _dt(sweep: Sweep) -> float:
    return float(sweep.config.integrate.dt)


WORDS = (
    Word("dt: 0.02", "dt: 2e-2", read=lambda sweep: _dt(sweep) == 0.02),
    Word("dt: 0.02", "dt: 1e-3", read=lambda sweep: _dt(sweep) == 0.001),
    Word("dt: 0.02", "dt: 2.E-2", read=lambda sweep: _dt(sweep) == 0.02),
    Word("dt: 0.02", "dt: .02", read=lambda sweep: _dt(sweep) == 0.02),
    Word("dt: 0.02", "dt: +0.02", read=lambda sweep: _dt(sweep) == 0.02),
    Word("dt: 0.02", 'dt: "0.02"', "integrate.dt: '0.02' is not accepted"),
    Word("dt: 0.02", "dt: 0.02s", "integrate.dt: '0.02s' is not accepted"),
    Word("dt: 0.02", "dt: .inf", "integrate.dt: .inf is not accepted"),
    Word("dt: 0.02", "dt: -.INF", "integrate.dt: -.INF is not accepted"),
    Word("dt: 0.02", "dt: .nan", "integrate.dt: .nan is not accepted"),
    Word("dt: 0.02", "dt: inf", "integrate.dt: 'inf' is not accepted"),
    Word("dt: 0.02", "dt: 1e400", "integrate.dt: 1e400 is not accepted"),
    Word("dt: 0.02", "dt: 0_1", "integrate.dt: '0_1' is not accepted"),
    Word("dt: 0.02", "dt: 0:0:1", "integrate.dt: '0:0:1' is not accepted"),
    Word("dt: 0.02", "dt: 1/50", "integrate.dt: '1/50' is not accepted"),
    Word("dt: 0.02", "dt: !!float 0.02", "integrate.dt: tags are not allowed"),
    Word("dt: 0.02", "dt: !!python/object/apply:os.system [id]", "integrate.dt: tags are not allowed"),
    Word("dt: 0.02", "dt: 0.02, dt: 0.01", "integrate.dt: duplicate key"),
    Word("dt: 0.02", 'dt: 0.02, "dt": 0.02', "integrate.dt: duplicate key"),
    Word("dt: 0.02", "<<: {dt: 0.02}", "merging mappings is not allowed"),
    Word("dt: 0.02", "dt: &a 0.02", "integrate.dt: anchors and aliases are not allowed"),
    Word("num: 16", "num: 16.0", "axes.rho.num: 16.0 is not accepted"),
    Word("num: 16", "num: 0x10", read=lambda sweep: sweep.grid.size == 16),
    Word("num: 16", "num: 0o20", read=lambda sweep: sweep.grid.size == 16),
    Word("num: 16", "num: 016", read=lambda sweep: sweep.grid.size == 16),
    Word("num: 16", "num: 0b10", "axes.rho.num: '0b10' is not accepted"),
    Word("num: 16", "num: true", "axes.rho.num: true is not accepted"),
    Word("name: quick", "name: no", read=lambda sweep: sweep.name == "no"),
    Word("name: quick", "name: 2001-01-01", read=lambda sweep: sweep.name == "2001-01-01"),
    Word("name: quick", "name: 1.10", "name: 1.10 is not accepted"),
    Word("name: quick", "name: true", "name: true is not accepted"),
    Word("name: quick", "name: null", "name: the empty value null is not accepted"),
    Word("name: quick", "name: ../../etc", "name: '../../etc' is not accepted"),
    Word("name: quick", "name: quick\nstop_early: no", "stop_early: 'no' is not accepted"),
    Word("name: quick", "name: quick\nstop_early: off", "stop_early: 'off' is not accepted"),
    Word("name: quick", "name: quick\nstop_early: False", read=lambda sweep: not sweep.config.stop_early),
    Word("\nname: quick", "%YAML 1.2\n---\nname: quick", read=lambda sweep: sweep.name == "quick"),
    Word("\nname: quick", "%YAML 1.1\n---\nname: quick", "is not YAML 1.2"),
    Word("\nname: quick", "---\nname: quick", read=lambda sweep: sweep.name == "quick"),
    Word("\nname: quick", "---\nname: quick\n---\n", "a second document begins here"),
    Word("\nname: quick", "\ufeffname: quick", read=lambda sweep: sweep.name == "quick"),
)


def limit() -> None:
    """Bound the memory of this process."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    every: list[Bomb | Word] = [*WORDS, *arena.rng.sample(BOMBS, len(BOMBS))]
    with arena.place() as place:
        for number in range(cases):
            one = every[number % len(every)]
            note = _thrown(arena, one, place) if isinstance(one, Bomb) else _understood(one, place / "x.yaml")
            label = one.name if isinstance(one, Bomb) else one.new[:60]
            kind = "bomb" if isinstance(one, Bomb) else "refused" if one.says else "read"
            yield Case(not note, f"{label}: {note}" if note else "", silent="read as" in note, kinds=(kind,))


def _thrown(arena: Arena, bomb: Bomb, place: Path) -> str:
    """Return what is wrong with how a process of little memory takes a bomb."""
    with (path := place / "x.yaml").open("w") as file:
        file.write(bomb.text())
        file.flush()
        file.truncate(file.tell() + bomb.fill * SIZE)
    begin = time.monotonic()
    victim = arena.command(SMALL, place, ["run", str(path), "--dry-run"], prepare=limit)
    victim.wait()
    seconds = time.monotonic() - begin
    if victim.code != 2 or bomb.says not in victim.out or victim.out.count("\n") != 1:
        return f"exit {victim.code}, {victim.out[:300]}"
    return f"took {seconds:.0f} s" if seconds > SECONDS else ""


def _understood(word: Word, path: Path) -> str:
    """Return what is wrong with how a word is read."""
    path.write_bytes(BASE.replace(word.old, word.new, 1).encode())
    command = Command(path)
    if word.says:
        said = command.code == 2 and word.says in command.told and command.told.count("\n") == 1
        return "" if said else f"exit {command.code}, {command.told[:300]}"
    if command.code:
        return f"exit {command.code}, {command.told[:300]}"
    return "" if word.read(load_sweep(path)) else "read as something else"


FAULTS = (
    Fault(
        "F32", "YAML bombs, and words that are easily misread", len(WORDS) + 6, 2 * (len(WORDS) + len(BOMBS)), _attack
    ),
)
