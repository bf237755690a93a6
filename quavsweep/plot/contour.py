"""Where a function is zero: lines on a mesh in the plane, positions on a line; poles are none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

NEAR = 1e-6  # of the distance of two mesh points


def zero_lines(x: np.ndarray, y: np.ndarray, values: np.ndarray, at: Callable[..., np.ndarray]) -> list[np.ndarray]:
    """Return the lines on which a function changes sign continuously.

    Parameters
    ----------
    x, y : (n,), (m,) float64
        An even mesh.
    values : (n, m) float64
        The function there; NaN where there is none.
    at : callable
        The function of points, `at(x, y)`, to tell zeros from poles.

    Returns
    -------
    list of (k, 2) float64
    """
    finite = values[np.isfinite(values)]
    if not finite.size or finite.min() > 0 or finite.max() < 0 or finite.min() == finite.max():
        return []
    found = Figure().subplots().contour(x, y, np.ma.masked_invalid(values.T), levels=[0.0]).allsegs[0]
    return [piece for line in found if len(line) for piece in _continuous(np.asarray(line), x, y, values, at)]


def _continuous(
    line: np.ndarray, x: np.ndarray, y: np.ndarray, values: np.ndarray, at: Callable[..., np.ndarray]
) -> list[np.ndarray]:
    """Return the pieces of a contour without points at which the function is not small.

    A point lies on an edge of the mesh. Towards a zero the function falls below its values at both ends of the
    edge; beside a pole it does not. On a corner of the mesh the contour is an exact zero.
    """
    i, j = (line[:, 0] - x[0]) / (x[1] - x[0]), (line[:, 1] - y[0]) / (y[1] - y[0])
    low, high = ([f(k + nudge) for k in (i, j)] for f, nudge in ((np.floor, NEAR), (np.ceil, -NEAR)))
    ends = [values[_index(corner[0], len(x)), _index(corner[1], len(y))] for corner in (low, high)]
    smaller, larger = np.minimum(*np.abs(ends)), np.maximum(*np.abs(ends))
    on_corner = (np.abs(i - np.round(i)) < NEAR) & (np.abs(j - np.round(j)) < NEAR)
    with np.errstate(invalid="ignore"):
        good = on_corner | (np.abs(at(line[:, 0], line[:, 1])) <= smaller + 1e-9 * larger)
    runs = np.split(np.arange(len(line)), np.flatnonzero(np.diff(good)) + 1)
    return [line[run] for run in runs if good[run[0]] and len(run) > 1]


def _index(position: np.ndarray, length: int) -> np.ndarray:
    return np.asarray(np.clip(position, 0, length - 1), dtype=int)


def roots(x: np.ndarray, at: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Return where a function changes sign continuously along a line, by bisection; nothing where it is zero all along.

    Parameters
    ----------
    x : (n,) float64
        An ascending mesh.
    at : callable
        The function.
    """
    with np.errstate(all="ignore"):
        sign = np.sign(at(x))
        beside = np.concatenate([[1.0], sign, [1.0]])
        exact = x[(sign == 0) & (beside[:-2] != 0) & (beside[2:] != 0)]
        first = np.flatnonzero(sign[:-1] * sign[1:] < 0)  # never beside what is no number
        low, high, below = x[first], x[first + 1], sign[first]
        start = np.minimum(np.abs(at(low)), np.abs(at(high)))
        for _ in range(60):
            middle = 0.5 * (low + high)
            left = np.sign(at(middle)) == below
            low, high = np.where(left, middle, low), np.where(left, high, middle)
        return np.sort(np.concatenate([exact, low[np.abs(at(low)) <= start]]))
