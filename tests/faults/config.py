"""F31: configs that are wrong: mutants with a key that is known to be broken, YAML and bytes at random; and bugs."""

from __future__ import annotations

import contextlib
import io
import random
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from unittest.mock import patch

import quavsweep.cli
from quavsweep.errors import ConfigError
from tests.broken_config import BASES, is_named
from tests.faults.arena import Arena
from tests.faults.fault import Case, Fault
from tests.faults.subject import SMALL
from tests.mutation import ALIASES, NUMBERS, TAGS, TYPES, entries, mutant

NEVER = ("tag", "duplicate")  # mutations that no config stays right with; others may leave one as good
BUG = 1
USAGE = 2
PLACES = ("read_config", "apply_changes", "check_ensemble", "make_grid", "check_domains", "choose_clock", "Sweep")
BUGS = (ValueError("a bug"), KeyError("key"), ZeroDivisionError("by zero"), RecursionError("deep"), AssertionError())
TOKENS = (
    *"{}[]:,-?&*!|>'\"%@`#~ \n\t\\",
    ": ",
    "- ",
    "\n  ",
    "---\n",
    "...\n",
    "<<",
    "\r\n",
    "\u2028",
    "\x85",
    "\ufeff",
)
WORDS = (*TYPES, *NUMBERS, *TAGS, *ALIASES)
KEYS = sorted({entry.path[-1] for text in BASES for entry in entries(text)})


class Command:
    """`quavsweep run FILE --dry-run` in this process, up to where it would integrate.

    Attributes
    ----------
    code : int
    told : str
        What was printed.
    error : Exception or None
        Of which the command line made that.
    """

    def __init__(self, path: Path) -> None:
        self.error: BaseException | None = None
        known, output = quavsweep.cli._explain, io.StringIO()

        def explain(error: BaseException) -> tuple[str, int]:
            self.error = error
            return known(error)

        run = import_module("quavsweep.cli.run")
        with (
            patch.object(quavsweep.cli, "_explain", explain),
            patch.object(run, "stop_on_signals", lambda max_time: threading.Event()),
            patch.object(run, "_preview", lambda *arguments: None),
            patch.object(sys, "argv", ["quavsweep", "run", str(path), "--dry-run"]),
            contextlib.redirect_stdout(output),
            contextlib.redirect_stderr(output),
        ):
            self.code = quavsweep.cli._main()
        self.told = output.getvalue()


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    ways = [_mutant] * 60 + [_random_yaml] * 20 + [_noise] * 10 + [_random_bytes] * 8 + [_in_a_process, _with_a_bug]
    with arena.place() as place:
        for number in range(cases):
            # The rare ways come once in a hundred cases, in a new order each time.
            if number % len(ways) == 0:
                arena.rng.shuffle(ways)
            yield ways[number % len(ways)](arena, place)


def _mutant(arena: Arena, place: Path) -> Case:
    """Return what is said of a config with one broken key."""
    path = place / "x.yaml"
    while True:
        broken = mutant(arena.rng, arena.rng.choice(BASES))
        path.write_bytes(broken.text)
        command = Command(path)
        if command.code != 0:
            break
        if broken.kind in NEVER:
            return Case(
                False, f"{broken.kind} of {'.'.join(broken.paths[0])} was accepted: {broken.text!r}", silent=True
            )
    note = _wrong(command, path)
    named = isinstance(command.error, ConfigError) and is_named(broken, command.error)
    key = f"{broken.kind} of {'.'.join(broken.paths[0])}"
    return Case(not note, f"{key}: {note}" if note else "", kinds=("mutant", *([] if named else ["mutant not named"])))


def _random_yaml(arena: Arena, place: Path) -> Case:
    """Return what is said of YAML at random, most of it none."""
    rng = arena.rng
    text = (
        _tree(rng, 0)
        if rng.random() < 0.5
        else "".join(rng.choice((*TOKENS, *WORDS)) for _ in range(rng.randrange(60)))
    )
    return _said(place, text.encode("utf-8", "surrogatepass"), "YAML")


def _tree(rng: random.Random, depth: int) -> str:
    """Return a mapping or list in flow style, with keys that a config has, or some word."""
    if depth > 4 or rng.random() < 0.3 * (depth > 0):
        return rng.choice(WORDS)
    inside = [_tree(rng, depth + 1) for _ in range(rng.randrange(6))]
    if rng.random() < 0.3:
        return f"[{', '.join(inside)}]"
    keys = [rng.choice(KEYS if rng.random() < 0.9 else WORDS) for _ in inside]
    return "{" + ", ".join(f"{key}: {value}" for key, value in zip(keys, inside, strict=True)) + "}"


def _noise(arena: Arena, place: Path) -> Case:
    """Return what is said of a config some bytes of which are others, gone or twice there."""
    data = bytearray(arena.rng.choice(BASES).encode())
    for _ in range(arena.rng.randrange(1, 8)):
        at = arena.rng.randrange(len(data))
        data[at : at + arena.rng.randrange(3)] = arena.rng.randbytes(arena.rng.randrange(3))
    return _said(place, bytes(data), "noise")


def _random_bytes(arena: Arena, place: Path) -> Case:
    """Return what is said of bytes at random."""
    return _said(place, arena.rng.randbytes(arena.rng.choice([0, 1, 3, 30, 300, 3000])), "bytes")


def _said(place: Path, data: bytes, kind: str) -> Case:
    """Return what is said of a text that may even be a config."""
    (path := place / "x.yaml").write_bytes(data)
    command = Command(path)
    note = _wrong(command, path) if command.code else ""
    return Case(
        not note, f"{kind} {data[:200]!r}: {note}" if note else "", kinds=(kind if command.code else "a config",)
    )


def _wrong(command: Command, path: Path) -> str:
    """Return what is wrong with a refusal: it is one line with the file and exit code 2."""
    line = command.told.removesuffix("\n")
    good = line.isprintable() and line.startswith(f"quavsweep: {path}") and line == f"quavsweep: {command.error}"
    return "" if good and command.code == USAGE else f"exit {command.code}, {command.told[:400]}"


def _in_a_process(arena: Arena, place: Path) -> Case:
    """Return whether a process of its own says the same as this one."""
    while True:
        (path := place / "x.yaml").write_bytes(mutant(arena.rng, arena.rng.choice(BASES)).text)
        here = Command(path)
        if here.code != 0:
            break
    victim = arena.command(SMALL, place, ["run", str(path), "--dry-run"])
    same = victim.wait() == here.code and victim.out == here.told
    return Case(same, "" if same else f"exit {victim.code}, {victim.out[:300]} / {here.told[:300]}", kinds=("process",))


def _with_a_bug(arena: Arena, place: Path) -> Case:
    """Return what is said of a config that is right, by a program that is not."""
    bug, name = arena.rng.choice(BUGS), arena.rng.choice(PLACES)
    (path := place / "x.yaml").write_text(arena.rng.choice(BASES))
    with patch(f"quavsweep.config.load.{name}", side_effect=bug):
        command = Command(path)
    says = f"quavsweep: this is a bug in quavsweep: {type(bug).__name__}: {bug}; --traceback shows where\n"
    good = command.code == BUG and command.told == says
    return Case(good, "" if good else f"exit {command.code}, {command.told[:300]}", kinds=("bug",))


def _whole(kinds: Counter[str], cases: int) -> str:
    """Return what is wrong with how many broken keys were named."""
    missed, mutants = kinds["mutant not named"], kinds["mutant"]
    chance = 5 if mutants < 2000 else 0  # of few, some more may happen to be those that are hard to name
    return f"{missed} of {mutants} broken keys were not named" if missed > 0.01 * mutants + chance else ""


FAULTS = (Fault("F31", "invalid configs: mutants, random YAML, random bytes, bugs", 500, 20_000, _attack, _whole),)
