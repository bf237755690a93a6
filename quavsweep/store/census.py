"""How many cells of a result have which code, counted block by block, so that it may be larger than the memory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from quavsweep.codes import Code
from quavsweep.store.stored import Stored

CELLS = 2**20  # that are read at once, a byte or two each


def code_blocks(stored: Stored, *names: str) -> Iterator[tuple[np.ndarray, ...]]:
    """Yield some variables with a code per cell, flat, a block of cells at a time."""
    for part in stored.grid(names[0]).blocks(CELLS):
        yield tuple(np.ravel(stored.part(name, part)) for name in names)


def code_counts(stored: Stored, name: str, codes: tuple[Code, ...]) -> np.ndarray:
    """Return how many cells have each code, (codes,) int64."""
    count = np.zeros(len(codes), dtype=np.int64)
    for (values,) in code_blocks(stored, name):
        count += np.bincount(values, minlength=len(codes))
    return count
