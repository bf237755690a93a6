"""Reference orbits: extrapolation in extended precision, independent of every contender."""

from __future__ import annotations

from functools import cache

import numpy as np

from benchmarks.cells import Cells

SUBSTEPS = (2, 4, 6, 8, 10, 12, 14, 16)  # of the modified midpoint rule; extrapolated to order 16


def reference_state(cells: Cells, seconds: float, dt: float = 0.1) -> np.ndarray:
    """Return the states after a time, (n, D), by the method of Gragg, Bulirsch and Stoer with steps of `dt`.

    The model's own function is called with arrays of extended precision, so that rounding stays below 1e-16.
    """
    u = [np.asarray(x, dtype=np.longdouble) for x in cells.u.T]
    p = {name: np.asarray(values, dtype=np.longdouble) for name, values in cells.parameters.items()}
    for _ in range(round(seconds / dt)):
        rows = [_midpoint(cells, u, p, np.longdouble(dt), n) for n in SUBSTEPS]
        u = [np.tensordot(_weights(), [row[i] for row in rows], 1) for i in range(len(u))]
    return np.stack(u, axis=1).astype(np.float64)


def _midpoint(
    cells: Cells, u: list[np.ndarray], p: dict[str, np.ndarray], dt: np.longdouble, substeps: int
) -> list[np.ndarray]:
    """Advance by one step of the smoothed midpoint rule, whose error is a series in (dt / substeps)^2."""
    h = dt / substeps
    before, now = u, [x + h * f for x, f in zip(u, cells.model.rhs(*u, **p), strict=True)]
    for _ in range(1, substeps):
        slopes = cells.model.rhs(*now, **p)
        before, now = now, [x + 2 * h * f for x, f in zip(before, slopes, strict=True)]
    slopes = cells.model.rhs(*now, **p)
    return [(x + y + h * f) / 2 for x, y, f in zip(before, now, slopes, strict=True)]


@cache
def _weights() -> np.ndarray:
    """Return the weights that extrapolate a polynomial in 1 / n^2 from `SUBSTEPS` to zero."""
    squares = np.array(SUBSTEPS, dtype=np.longdouble) ** 2
    return np.array([np.prod([a / (a - b) for b in squares if b != a]) for a in squares])
