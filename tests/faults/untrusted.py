"""F34: files from elsewhere: a corpus of hostile ones, then mutants of a good one with their seals made anew."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tests.faults.arena import Arena
from tests.faults.fault import Case, Fault
from tests.faults.hostile import CORPUS, attack, attempt, hostile, make_canary
from tests.faults.mutant import small_result


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    with arena.place() as place:
        make_canary(place)
        good = small_result(place / "run")
        for name in list(CORPUS)[:cases]:
            survived, silent, note = attempt(hostile(name, good, place))
            yield Case(survived, f"{name}: {note}", silent, ("corpus",))
        rng = np.random.default_rng(arena.rng.getrandbits(64))
        for survived, silent, kind, note in attack(max(0, cases - len(CORPUS)), rng, place):
            yield Case(survived, f"{kind}: {note}", silent, (kind, "read" if note == "read" else "refused"))


FAULTS = (Fault("F34", "a hostile HDF5 file", 300, 50_000, _attack),)
