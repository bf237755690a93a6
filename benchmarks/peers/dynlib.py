"""dynlib: RK4 with its sweep of Lyapunov spectra over a parameter, compiled by numba, in one process."""

from __future__ import annotations

import numpy as np

from benchmarks.cells import Cells
from benchmarks.peers import Peer, peer


def make_peer(cells: Cells, dt: float, seconds: float) -> Peer:
    """Return it with three exponents of Lorenz cells that differ in rho, all from one start, by RK4."""
    sweep = peer("dynlib.analysis").lyapunov_spectrum_sweep
    simulation = peer("dynlib").setup("builtin://ode/lorenz.toml", stepper="rk4", jit=True)
    simulation.assign(**dict(zip("xyz", map(float, cells.u[0]), strict=True)))
    options = {"param": "rho", "values": cells.parameters["rho"], "k": 3, "parallel_mode": "none"}

    def exponents() -> np.ndarray:
        return np.asarray(sweep(simulation, T=seconds, dt=dt, **options).outputs["spectrum"])

    return Peer("dynlib", exponents, seconds, len(cells))
