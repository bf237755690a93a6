"""Cycles closed by SciPy alone: Newton's method on point and period, with the model's plain function and DOP853."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

Rhs = Callable[..., Sequence[Any]]  # of states and parameters

TINY = 1e-30  # complex step
TOLERANCE = 1e-10
AT_ONCE = 250  # cells of similar periods in one system of equations
ITERATIONS = 8
CONVERGED = 10  # Newton's last step against 1 + |u|, in tolerances


@dataclass(frozen=True)
class Closed:
    """Orbits that close.

    Parameters
    ----------
    found : (n,) bool
        Newton's method has converged.
    point : (n, D) float64
    period : (n,) float64
    multipliers : (n, D) complex128
        Largest size first.
    """

    found: np.ndarray
    point: np.ndarray
    period: np.ndarray
    multipliers: np.ndarray


def field(rhs: Rhs, u: np.ndarray, p: Sequence[Any]) -> np.ndarray:
    """Return the derivatives of states in columns, (D, n)."""
    return np.stack(rhs(*u, *p))


def jacobian(rhs: Rhs, u: np.ndarray, p: Sequence[Any]) -> np.ndarray:
    """Return derivatives of the derivatives by complex steps, [i, j] = d rhs_i / d u_j, (D, D, n)."""
    columns = []
    for j in range(len(u)):
        moved = u.astype(complex)
        moved[j] += TINY * 1j
        columns.append(field(rhs, moved, p).imag / TINY)
    return np.stack(columns, axis=1)


def close(
    rhs: Rhs, u: np.ndarray, period: np.ndarray, parameters: Sequence[np.ndarray], tolerance: float = TOLERANCE
) -> Closed:
    """Return the cycles that Newton's method reaches from guesses of a point and the period.

    Parameters
    ----------
    rhs : callable
        The model's function.
    u : (n, D) float64
    period : (n,) float64
    parameters : sequence of (n,) arrays
    tolerance : float
        Relative, of DOP853.
    """
    n, dimension = u.shape
    found, point, times = np.zeros(n, bool), u.copy(), period.copy()
    multipliers = np.full((n, dimension), complex(np.nan, np.nan))
    order = np.argsort(period)
    for cells in (order[first : first + AT_ONCE] for first in range(0, n, AT_ONCE)):
        own = [p[cells] for p in parameters]
        for _ in range(ITERATIONS):
            end, derivative = _after(rhs, point[cells], times[cells], own, tolerance)
            step = _newton(rhs, point[cells], end, derivative, own)
            point[cells] += step[:, :-1]
            times[cells] += step[:, -1]
            size = np.linalg.norm(step, axis=1)
            found[cells] = size <= CONVERGED * tolerance * (1.0 + np.linalg.norm(point[cells], axis=1))
            if found[cells].all():
                break
        values = np.linalg.eigvals(derivative)
        multipliers[cells] = np.take_along_axis(values, np.argsort(-np.abs(values), axis=1), axis=1)
    return Closed(found, point, times, multipliers)


def _after(
    rhs: Rhs, u: np.ndarray, period: np.ndarray, p: Sequence[Any], tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return states after their periods, (n, D), and how they depend on where they began, (n, D, D)."""
    n, d = u.shape

    def derivative(_: float, flat: np.ndarray) -> np.ndarray:
        rows = flat.reshape(d + d * d, n)
        tangent = rows[d:].reshape(d, d, n)
        moved = np.einsum("ijn,jkn->ikn", jacobian(rhs, rows[:d], p), tangent)
        return np.asarray(np.concatenate([field(rhs, rows[:d], p), moved.reshape(d * d, n)]) * period).ravel()

    begin = np.concatenate([u.T, np.repeat(np.eye(d).reshape(d * d, 1), n, axis=1)])
    done = solve_ivp(derivative, (0.0, 1.0), begin.ravel(), "DOP853", [1.0], rtol=tolerance, atol=tolerance / 100)
    rows = done.y[:, -1].reshape(d + d * d, n)
    return rows[:d].T, rows[d:].reshape(d, d, n).transpose(2, 0, 1)


def _newton(
    rhs: Rhs,
    u: np.ndarray,
    end: np.ndarray,
    derivative: np.ndarray,
    p: Sequence[Any],
) -> np.ndarray:
    """Return Newton's step in point and period, (n, D + 1); the point moves across the flow."""
    n, d = u.shape
    matrix = np.zeros((n, d + 1, d + 1))
    matrix[:, :d, :d] = derivative - np.eye(d)
    matrix[:, :d, d] = field(rhs, end.T, p).T
    matrix[:, d, :d] = field(rhs, u.T, p).T
    right = np.concatenate([u - end, np.zeros((n, 1))], axis=1)
    return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0])
