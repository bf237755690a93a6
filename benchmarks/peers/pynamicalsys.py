"""pynamicalsys: RK4 with its own QR decomposition after every step, compiled by numba."""

from __future__ import annotations

import numpy as np
from numba import njit

from benchmarks.cells import Cells
from benchmarks.naive import coefficients
from benchmarks.peers import Peer, peer


@njit
def rhs(t, u, p):  # type: ignore[no-untyped-def]
    """Return the derivatives of the yaw system from its nine coefficients."""
    du = np.empty(3)
    du[0] = p[0] * u[1] * u[2] + p[1] * u[1] + p[2] * u[0]
    du[1] = p[3] * u[0] * u[2] + p[4] * u[0] + p[5] * u[1]
    du[2] = p[6] * u[0] * u[1] + p[7] * u[2] + p[8]
    return du


@njit
def jacobian(t, u, p):  # type: ignore[no-untyped-def]
    """Return the Jacobian of the yaw system."""
    J = np.empty((3, 3))
    J[0, 0], J[0, 1], J[0, 2] = p[2], p[0] * u[2] + p[1], p[0] * u[1]
    J[1, 0], J[1, 1], J[1, 2] = p[3] * u[2] + p[4], p[5], p[3] * u[0]
    J[2, 0], J[2, 1], J[2, 2] = p[6] * u[1], p[6] * u[0], p[7]
    return J


def make_peer(cells: Cells, dt: float, seconds: float) -> Peer:
    """Return it with three exponents of cells of the yaw system by RK4."""
    system = peer("pynamicalsys").ContinuousDynamicalSystem(
        equations_of_motion=rhs, jacobian=jacobian, system_dimension=3, number_of_parameters=9
    )
    system.integrator("rk4", time_step=dt)
    p = coefficients(**cells.parameters)

    def exponents() -> np.ndarray:
        return np.array([system.lyapunov(u, seconds, parameters=q) for u, q in zip(cells.u, p, strict=True)])

    return Peer("pynamicalsys", exponents, seconds, len(cells))
