"""Frozen: the scalar loop over arrays that most people write with numba, for the yaw system. Not to be improved."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit


def coefficients(
    *, Omega1: Any, c: Any, Ix: Any, Iy: Any, Iz: Any, Ir: Any, d: Any, k4: Any, k5: Any, k6: Any
) -> np.ndarray:
    """Return the nine coefficients of system (15) of n cells, (n, 9)."""
    rows = [
        *((Iy - Iz) / Ix, -2 * c * Ir / Ix, -k4 / Ix),
        *((Iz - Ix) / Iy, 2 * c * Ir / Iy, -k5 / Iy),
        *((Ix - Iy) / Iz, -k6 / Iz, 2 * d * (c**2 + 2 * c * Omega1) / Iz),
    ]
    return np.ascontiguousarray(np.transpose(rows))


@njit
def derivative(w, p, dw):  # type: ignore[no-untyped-def]
    """Fill the derivatives of the state and of three tangent vectors, w = (u, q1, q2, q3)."""
    a1, a2, a3, b1, b2, b3, c1, c2, c3 = p
    x, y, z = w[0], w[1], w[2]
    dw[0] = a1 * y * z + a2 * y + a3 * x
    dw[1] = b1 * x * z + b2 * x + b3 * y
    dw[2] = c1 * x * y + c2 * z + c3
    for k in range(1, 4):
        q0, q1, q2 = w[3 * k], w[3 * k + 1], w[3 * k + 2]
        dw[3 * k] = a3 * q0 + (a1 * z + a2) * q1 + a1 * y * q2
        dw[3 * k + 1] = (b1 * z + b2) * q0 + b3 * q1 + b1 * x * q2
        dw[3 * k + 2] = c1 * y * q0 + c1 * x * q1 + c2 * q2


@njit
def rk4_step(w, p, dt, k1, k2, k3, k4, v):  # type: ignore[no-untyped-def]
    """Advance state and tangent vectors by one step, in place."""
    n = w.size
    derivative(w, p, k1)
    for i in range(n):
        v[i] = w[i] + 0.5 * dt * k1[i]
    derivative(v, p, k2)
    for i in range(n):
        v[i] = w[i] + 0.5 * dt * k2[i]
    derivative(v, p, k3)
    for i in range(n):
        v[i] = w[i] + dt * k3[i]
    derivative(v, p, k4)
    for i in range(n):
        w[i] += dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])


@njit
def gram_schmidt(w, sums):  # type: ignore[no-untyped-def]
    """Orthonormalise the three tangent vectors in place and add the logarithms of their lengths."""
    for k in range(3):
        for j in range(k):
            dot = 0.0
            for i in range(3):
                dot += w[3 + 3 * k + i] * w[3 + 3 * j + i]
            for i in range(3):
                w[3 + 3 * k + i] -= dot * w[3 + 3 * j + i]
        norm = 0.0
        for i in range(3):
            norm += w[3 + 3 * k + i] ** 2
        norm = np.sqrt(norm)
        for i in range(3):
            w[3 + 3 * k + i] /= norm
        sums[k] += np.log(norm)


@njit
def sweep(start, p, dt, block, n_blocks, end, sums):  # type: ignore[no-untyped-def]
    """Integrate cell after cell.

    Parameters
    ----------
    start, end : (n, 12) float64
        State and tangent vectors; `end` is filled.
    p : (n, 9) float64
        Coefficients.
    dt : float
        Step [s].
    block, n_blocks : int
        Steps between two orthonormalisations, number of blocks.
    sums : (n, 3) float64, output
        Sums of ln of the stretching factors.
    """
    k1, k2, k3, k4, v = np.empty(12), np.empty(12), np.empty(12), np.empty(12), np.empty(12)
    for cell in range(start.shape[0]):
        w = start[cell].copy()
        sums[cell] = 0.0
        for _ in range(n_blocks):
            for _ in range(block):
                rk4_step(w, p[cell], dt, k1, k2, k3, k4, v)
            gram_schmidt(w, sums[cell])
        end[cell] = w
