"""Where a function is zero: lines on a mesh in the plane, positions on a line; poles are none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure


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
    edge; beside a pole it does not.
    """
    i, j = (line[:, 0] - x[0]) / (x[1] - x[0]), (line[:, 1] - y[0]) / (y[1] - y[0])
    ends = [values[_index(round_(i), len(x)), _index(round_(j), len(y))] for round_ in (np.floor, np.ceil)]
    smaller, larger = np.minimum(*np.abs(ends)), np.maximum(*np.abs(ends))
    with np.errstate(invalid="ignore"):
        good = np.abs(at(line[:, 0], line[:, 1])) <= smaller + 1e-9 * larger
    runs = np.split(np.arange(len(line)), np.flatnonzero(np.diff(good)) + 1)
    return [line[run] for run in runs if good[run[0]] and len(run) > 1]


def _index(position: np.ndarray, length: int) -> np.ndarray:
    return np.asarray(np.clip(position, 0, length - 1), dtype=int)


def roots(x: np.ndarray, at: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Return where a function changes sign continuously along a line, by bisection.

    Parameters
    ----------
    x : (n,) float64
        An ascending mesh.
    at : callable
        The function.
    """
    sign = np.sign(at(x))
    exact = x[sign == 0]
    first = np.flatnonzero(sign[:-1] * sign[1:] < 0)
    low, high, below = x[first], x[first + 1], sign[first]
    start = np.minimum(np.abs(at(low)), np.abs(at(high)))
    for _ in range(60):
        middle = 0.5 * (low + high)
        left = np.sign(at(middle)) == below
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    return np.sort(np.concatenate([exact, low[np.abs(at(low)) <= start]]))
