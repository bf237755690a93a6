"""F28: a model edited between two runs, without a change of its file's size and time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quavsweep.result import open_result
from tests.faults.arena import Arena
from tests.faults.fault import Case, Fault
from tests.faults.subject import Subject

# What `push` gives x, four terms take from it. Python's own cache of bytecode would not see an edit of the helper.
MODEL = """
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.dont_write_bytecode = True

from helper_{number} import slope
from quavsweep.models import Model, Parameter, State

EXTRA = 1.0
DATA = float(Path(__file__).with_name("data.txt").read_text())


def more(x):
    return 1.0 * x


def rhs(x, push):
    return (push * 1.0 - slope(x) - EXTRA * x - DATA * x - more(x),)


MODEL = Model(name="edited", rhs=rhs, states=(State("x"),), parameters=(Parameter("push", 1.0),))
"""
HELPER = """
def slope(x):
    return 1.0 * x
"""
CONFIG = """
name: edited
model: edited
initial: {x: 1.0}
axes: {push: {values: [1, 2, 3]}}
integrate: {dt: 0.1, transient: 50, duration: 50}
"""


@dataclass(frozen=True)
class Change:
    """An edit of a file: what is put for what, and where x ends then for a push of 1."""

    name: str
    file: str
    old: str
    new: str
    end: float


CHANGES = (
    Change("number in the equations", "model.py", "push * 1.0", "push * 5.0", 5 / 4),
    Change("number of the module", "model.py", "EXTRA = 1.0", "EXTRA = 4.0", 1 / 7),
    Change("function of the module", "model.py", "1.0 * x", "9.0 * x", 1 / 12),
    Change("function of another file", "helper", "1.0 * x", "3.0 * x", 1 / 6),
    Change("data that the file reads", "data.txt", "1.0", "2.0", 1 / 5),
)


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    for number in range(cases):
        change = CHANGES[number % len(CHANGES)]
        with arena.place() as place:
            note = _edited(arena, change, place, number)
            yield Case(not note, f"{change.name}: {note}" if note else "", "old" in note, (change.name,))


def _edited(arena: Arena, change: Change, place: Path, number: int) -> str:
    """Return what is wrong with the numbers before and after an edit, in a new folder, and in the same one."""
    files = {"model.py": MODEL.format(number=number), f"helper_{number}.py": HELPER, "data.txt": "1.0\n"}
    for name, text in files.items():
        (place / name).write_text(text)
    path = next(place / name for name in files if name.startswith(change.file))
    before = path.stat()
    note = _wrong(arena, place, "before", 1 / 4)
    path.write_text(path.read_text().replace(change.old, change.new, 1))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    if path.stat().st_size != before.st_size:
        raise ValueError(f"{change} changes the size")
    note = note or _wrong(arena, place, "after", change.end)
    same = _run(arena, place, "before")
    return note or ("" if same.startswith("4 ") else f"the same folder: {same}")


def _wrong(arena: Arena, place: Path, name: str, end: float) -> str:
    """Return what is wrong with a run into a folder: the equilibria in which it ends."""
    told = _run(arena, place, name)
    if not told.startswith("0 "):
        return f"exit {told}"
    states = open_result(place / name / "result.h5")["equilibrium"][:, 0]
    return "" if np.allclose(states, end * np.array([1, 2, 3]), rtol=1e-9) else f"old numbers {name}: {states}"


def _run(arena: Arena, place: Path, name: str) -> str:
    """Run the model into a folder and return exit code and output."""
    subject = Subject("edited", CONFIG)
    command = ["run", str(arena.config(subject)), "--model", str(place / "model.py"), "--out", str(place / name)]
    victim = arena.command(subject, place, [*command, "--no-plot"])
    return f"{victim.wait()} {victim.out[-300:]}"


FAULTS = (Fault("F28", "a model edited between two runs, same size, same time", 5, 25, _attack),)
