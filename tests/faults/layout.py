"""F26: the result does not depend on workers, where they are, tiles, their order, or lanes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import quavsweep.sweep
from quavsweep.kernels.compiler import default_lanes
from tests.faults.arena import Arena, sha256
from tests.faults.crew import Site, have_children, local, scheduled
from tests.faults.fault import Case, Fault
from tests.faults.subject import SUBJECTS, Subject

WORKERS = (1, 2, 3, 7)
TILES = (5, 16, 80)
LANES = (default_lanes(), 24)
PUSH = 12


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    for subject in SUBJECTS:
        arena.undisturbed(subject)
    tiles, lanes = (TILES, LANES) if cases <= PUSH else ((1, 3, *TILES), (*LANES, 16, 40))
    with scheduled(arena.folder / "cluster") as site:
        for sites in itertools.repeat((*map(_threads, WORKERS), local(2), site)):
            for place in sites:
                if cases == 0:
                    return
                cases -= 1
                yield _run(arena, arena.rng.choice(SUBJECTS), place, arena.rng.choice(tiles), arena.rng.choice(lanes))


def _threads(workers: int) -> Site:
    return Site(f"threads {workers}", ("--workers", str(workers)))


def _run(arena: Arena, subject: Subject, site: Site, cells: int, lanes: int) -> Case:
    """Return whether a run of a layout, whose tiles are in a random order, gives the bytes of the undisturbed one."""
    with arena.place() as place:
        tiled = replace(subject, tile_cells=cells)
        victim = arena.start(tiled, place, site.arguments, prepare=partial(_prepare, lanes))
        code = victim.wait()
        same = sha256(place / "run" / "result.h5") == arena.undisturbed(subject).digest
        layout = f"{site.name}, tiles of {cells}, {lanes} lanes"
        note = f"{layout}: ended with {code}: {victim.out[-300:]}" if code != 0 else "" if same else f"{layout}: bytes"
        return Case(not note, note, silent=code == 0 and not same, kinds=tuple(layout.split(", ")))


def _prepare(lanes: int) -> None:
    """Force the number of lanes."""
    have_children()
    vars(quavsweep.sweep).update(default_lanes=lambda: lanes)


FAULTS = (Fault("F26", "other workers, processes, tiles, orders, lanes", PUSH, 60, _attack),)
