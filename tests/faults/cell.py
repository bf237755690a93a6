"""F25: cells that diverge, overflow, divide by zero, never settle, between cells that do not mind."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import quavsweep.work
from quavsweep.codes import Status
from quavsweep.grid import Tile
from quavsweep.measures import Evidence
from quavsweep.plan import Plan
from quavsweep.result import Result, open_result
from tests.faults.arena import Arena, Prepare
from tests.faults.fault import Case, Fault
from tests.faults.kill import shard_files
from tests.faults.subject import Subject

MODEL = """
from quavsweep.models import Model, Parameter, State
from quavsweep.models.function import exp, log, tan

ZERO = "decay spin cube grow fast rise pole turn void fall"
AWAY = {"place": 1e9, "inside": 1.0}


def rhs(x, y, h, decay, spin, cube, grow, fast, rise, pole, turn, void, fall, place, inside):
    r = cube * (x * x + y * y)
    dx = (cube - decay + grow - r) * x - spin * y + rise * exp(x) + pole / (x - place) + void * log(inside)
    dy = (cube - decay - fast - r) * y + spin * x + turn * tan(x)
    return dx, dy, -fall + decay * (1 - h)


MODEL = Model(
    name="odd",
    rhs=rhs,
    states=(State("x"), State("y"), State("h", low=0.0)),
    parameters=(*(Parameter(name, 0.0) for name in ZERO.split()), *(Parameter(*pair) for pair in AWAY.items())),
)
"""
DEFAULTS = {"place": 1e9, "inside": 1.0}
CONFIG = """
name: odd
model: odd
initial: {{x: 1.0, y: 0.5, h: 1.0}}
axes: {{case: {{zip: {cells}}}}}
integrate: {{dt: 0.02, transient: 20, duration: 40}}
measures: {{lyapunov: {{exponents: 3, block: 25}}}}
"""


@dataclass(frozen=True)
class Kind:
    """A kind of cell: its parameters, and the status that it ends in."""

    name: str
    status: Status
    parameters: dict[str, float] = field(default_factory=dict)


GOOD = (
    Kind("sink", Status.ENDED_SINK, {"decay": 1.0, "spin": 2.0}),
    Kind("cycle", Status.ENDED_CYCLE, {"cube": 1.0, "spin": 1.0, "decay": 0.25}),
    Kind("centre", Status.TIME_OVER, {"spin": 1.0}),
    Kind("slow sink", Status.ENDED_SINK, {"decay": 0.5, "spin": 1.0}),
    Kind("other cycle", Status.ENDED_CYCLE, {"cube": 1.5, "spin": 2.0, "decay": 0.5}),
)
BAD = (
    Kind("grows", Status.DIVERGED, {"grow": 1.0}),
    Kind("overflows", Status.DIVERGED, {"rise": 1.0}),
    Kind("blows up", Status.DIVERGED, {"cube": -1.0}),
    Kind("divides by zero", Status.DIVERGED, {"pole": 1.0, "place": 1.0}),
    Kind("meets a pole", Status.DIVERGED, {"pole": -1.0, "place": 0.0, "rise": 1.0}),
    Kind("logarithm of less than 0", Status.DIVERGED, {"void": 1.0, "inside": -1.0}),
    Kind("step too long", Status.DIVERGED, {"fast": 1e6}),
    Kind("largest numbers", Status.DIVERGED, {"spin": 1e300}),
    Kind("leaves its domain", Status.LEFT_DOMAIN, {"fall": 0.1, "spin": 1.0}),
    Kind("loses its frame", Status.FRAME_DEGENERATE, {"fast": 60.0}),
    Kind("never settles", Status.TIME_OVER, {"spin": 1.0, "grow": 1e-4}),
)
NAMES = sorted({name for kind in (*GOOD, *BAD) for name in kind.parameters})


class WrongEndError(Exception):
    """A run ended with another code than it should."""


def fail_at(cell: int) -> None:
    """Let the tile raise that holds a cell."""
    integrate = vars(quavsweep.work)["integrate_tile"]

    def integrate_or_raise(plan: Plan, tile: Tile, stopped: Callable[[], bool]) -> Evidence:
        if tile.start <= cell < tile.stop:
            raise FloatingPointError("a tile that raises")
        return dict(integrate(plan, tile, stopped))

    vars(quavsweep.work).update(integrate_tile=integrate_or_raise)


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    (arena.folder / "odd.py").write_text(MODEL)
    with arena.place() as place:
        alone = _run(arena, GOOD, place, 3)
        kinds: list[Kind | str] = ["failed", "not computed", *reversed(BAD)]
        for number in range(cases):
            kind = kinds[number % len(kinds)]
            with arena.place() as case:
                name = kind if isinstance(kind, str) else kind.name
                try:
                    note = _among(arena, kind, case, alone)
                except WrongEndError as error:
                    note = str(error)
                yield Case(not note, f"{name}: {note}" if note else "", "other bits" in note, (name,))


def _among(arena: Arena, kind: Kind | str, place: Path, alone: Result) -> str:
    """Return what is wrong with cells of a kind and with their neighbours."""
    rng = arena.rng
    order: list[Kind] = [*GOOD]
    for bad in (kind, *rng.sample(BAD, rng.randrange(3, 7))):
        if isinstance(bad, Kind) and bad not in order:
            order.insert(rng.randrange(len(order) + 1), bad)
    tile_cells = rng.choice([1, 2, 3, 5, 20])
    if kind == "failed":
        cell = rng.randrange(len(order))
        result = _run(arena, order, place, tile_cells, partial(fail_at, cell), 3)
        return _differences(order, result, alone, cell // tile_cells, tile_cells, Status.FAILED)
    result = _run(arena, order, place, tile_cells)
    if kind == "not computed":
        (place / "run" / "result.h5").unlink()
        (path := rng.choice(sorted(shard_files(place / "run")))).unlink()
        tile = int(path.name.split(".")[0].removeprefix("tile-"))
        result = open_result(place / "run")
        return _differences(order, result, alone, tile, tile_cells, Status.NOT_COMPUTED)
    return _differences(order, result, alone)


def _run(
    arena: Arena, kinds: Sequence[Kind], place: Path, tile_cells: int, prepare: Prepare | None = None, code: int = 0
) -> Result:
    """Return the result of a run of cells of these kinds."""
    cells = {name: [kind.parameters.get(name, DEFAULTS.get(name, 0.0)) for kind in kinds] for name in NAMES}
    (config := place / "odd.yaml").write_text(CONFIG.format(cells=json.dumps(cells)))
    command = ["run", str(config), "--model", str(arena.folder / "odd.py"), "--out", str(place / "run"), "--no-plot"]
    subject = Subject("odd", "", tile_cells)
    victim = arena.command(subject, place, command, prepare=prepare)
    if victim.wait() != code:
        raise WrongEndError(f"exit {victim.code}: {victim.out[-300:]}")
    return open_result(place / "run" / "result.h5")


def _differences(
    order: Sequence[Kind], result: Result, alone: Result, tile: int = 0, tile_cells: int = 0, lost: Status | None = None
) -> str:
    """Return which cells have another status than documented, and which good ones other bits than alone.

    The cells of a tile may be lost, with a status that says how.
    """
    for cell, kind in enumerate(order):
        gone = lost is not None and tile_cells * tile <= cell < tile_cells * (tile + 1)
        status = Status(int(result["status"][cell]))
        if status != (lost if gone else kind.status):
            return f"{kind.name} is {status.name}"
        if kind in GOOD and not gone:
            names = [name for name in alone.variables if alone.stored.dims[name][:1] == ("case",)]
            row = GOOD.index(kind)
            wrong = [name for name in names if result[name][cell].tobytes() != alone[name][row].tobytes()]
            if wrong:
                return f"other bits of {', '.join(wrong)} in {kind.name}"
    return ""


FAULTS = (Fault("F25", "cells that diverge, overflow, divide by zero, never settle", 6, 65, _attack),)
