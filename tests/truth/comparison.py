"""Results against each other, cell by cell and to the bit."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from quavsweep import Result


def differences(a: Result, b: Result, names: Iterable[str], cells: np.ndarray | None = None) -> dict[str, int]:
    """Return the variables of `a` that are not those of `b`, and in how many of the cells, (n,) bool.

    What is no number in both counts as equal; a variable that `b` lacks differs everywhere.
    """
    differ = {}
    chosen = np.ones(a["region"].size, dtype=bool) if cells is None else cells
    for name in names:
        n = int((_unlike(a[name], b[name], chosen.size) if name in b else chosen)[chosen].sum())
        if n:
            differ[name] = n
    return differ


def _unlike(a: np.ndarray, b: np.ndarray, cells: int) -> np.ndarray:
    if a.shape != b.shape:
        return np.ones(cells, dtype=bool)
    equal = np.isclose(a, b, rtol=0.0, atol=0.0, equal_nan=True)
    return np.asarray(~equal.reshape(cells, -1).all(axis=1))


def words(differ: dict[str, int]) -> str:
    """Return differences in words, empty if there are none."""
    return ", ".join(f"{name} in {n} cells" for name, n in differ.items())
