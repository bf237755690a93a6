"""Following a curve F(x) = 0, one equation fewer than unknowns, by pseudo-arclength with steps that suit its bends.

References
----------
.. [1] H. B. Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems (1977).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

System = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]  # x (m + 1,) -> F (m,), dF/dx (m, m + 1)

FIRST, LEAST, LARGEST = 1e-3, 1e-9, 5e-3  # steps, in units in which the curve is about one long
STRAIGHT = 0.99  # cosine of the angle between neighbouring tangents at least
MOST = 6000  # points
CORRECTIONS = 8
CLOSED_IN = 1e-13  # last Newton step
NEARLY = 1e-9  # last Newton step that is accepted where rounding allows no smaller one


@dataclass(frozen=True)
class Window:
    """Where curves are followed: between `low` and `high` (m + 1,), infinite where there is no border."""

    low: np.ndarray
    high: np.ndarray

    def holds(self, x: np.ndarray) -> bool:
        """Whether a point lies inside."""
        return bool(((x >= self.low) & (x <= self.high)).all())

    def border(self, inside: np.ndarray, outside: np.ndarray) -> tuple[int, float]:
        """Return coordinate and value of the border that the chord between two points crosses first."""
        with np.errstate(divide="ignore", invalid="ignore"):
            bounds = np.where(outside > self.high, self.high, self.low)
            crossed = (outside > self.high) | (outside < self.low)
            share = np.where(crossed, (bounds - inside) / (outside - inside), np.inf)
        k = int(np.argmin(share))
        return k, float(bounds[k])


def tangent(jacobian: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return the unit tangent of the curve at a point, in the direction that is nearer to a given one."""
    direction: np.ndarray = np.linalg.svd(jacobian)[2][-1]
    return direction if direction @ along >= 0 else -direction


def corrected(system: System, guess: np.ndarray, normal: np.ndarray) -> np.ndarray | None:
    """Return the point of the curve in the plane through `guess` with a normal; None if Newton finds none nearby."""
    x, size = guess.copy(), np.inf
    for _ in range(CORRECTIONS):
        value, jacobian = system(x)
        table = np.vstack([jacobian, normal])
        try:
            step = np.linalg.solve(table, np.append(value, normal @ (x - guess)))
        except np.linalg.LinAlgError:
            return x if not value.any() else None
        if not np.isfinite(step).all():
            return None
        before, size = size, float(np.linalg.norm(step))
        if size > max(NEARLY, before):
            return None
        x = x - step
        if size <= CLOSED_IN * (1.0 + np.linalg.norm(x)):
            return x
    return x if size <= NEARLY * (1.0 + np.linalg.norm(x)) else None


def follow(system: System, start: np.ndarray, window: Window) -> np.ndarray:
    """Return the curve through a point of it, both ways until it leaves the window, closes, or cannot be followed.

    Parameters
    ----------
    start : (m + 1,) float64
        In units in which the curve is about one long.

    Returns
    -------
    (n, m + 1) float64
        In order along the curve; the last point equals the first if it closes.
    """
    along = tangent(system(start)[1], np.ones(len(start)))
    forward, closed = _one_way(system, start, along, window)
    if closed:
        return np.array([*forward, start])
    backward = _one_way(system, start, -along, window)[0]
    return np.array([*backward[:0:-1], *forward])


def _one_way(system: System, start: np.ndarray, along: np.ndarray, window: Window) -> tuple[list[np.ndarray], bool]:
    """Return the points of a curve from `start` on, and whether it came back."""
    points, x, step, away = [start], start, FIRST, False
    while len(points) < MOST and step >= LEAST:
        ahead = corrected(system, x + step * along, along)
        direction = None if ahead is None else tangent(system(ahead)[1], along)
        if ahead is None or direction is None or direction @ along < STRAIGHT:
            step *= 0.5
            continue
        if not window.holds(ahead):
            k, value = window.border(x, ahead)
            guess = x + (value - x[k]) / (ahead[k] - x[k]) * (ahead - x)
            guess[k] = value
            last = corrected(system, guess, np.eye(len(x))[k])
            return [*points, *([] if last is None else [last])], False
        away = away or float(np.linalg.norm(ahead - start)) > 3 * LARGEST
        if away and float(np.linalg.norm(ahead - start)) <= step and direction @ along > 0:
            return [*points, ahead], True
        points.append(ahead)
        x, along, step = ahead, direction, min(1.5 * step, LARGEST)
    return points, False


def zero_between(
    system: System, first: np.ndarray, second: np.ndarray, test: Callable[[np.ndarray], float]
) -> np.ndarray | None:
    """Return where a function changes sign on a curve between two neighbouring points of it, by the Illinois method."""
    chord = second - first
    normal = chord / np.linalg.norm(chord)
    low, high, below, above = 0.0, 1.0, test(first), test(second)
    found = None
    for _ in range(80):
        share = high - above * (high - low) / (above - below)
        found = corrected(system, first + share * chord, normal)
        if found is None:
            return None
        value = test(found)
        if value == 0.0:
            return found
        if value * above < 0:
            low, below = high, above
        else:
            below *= 0.5
        moved = abs(share - high)
        high, above = share, value
        if moved <= 1e-14 or abs(high - low) <= 1e-14:
            return found
    return found
