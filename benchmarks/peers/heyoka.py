"""heyoka: Taylor's method in batch mode with its own variational equations, orthonormalised every second."""

from __future__ import annotations

import numpy as np
from numba import njit

from benchmarks.cells import Cells
from benchmarks.peers import Peer, peer


@njit
def orthonormalise(w, sums):  # type: ignore[no-untyped-def]
    """Orthonormalise in place by modified Gram-Schmidt; compiled, so that heyoka does not wait for Python.

    Parameters
    ----------
    w : (12, B) float64
        State, then the matrix of tangent vectors row by row: component i of vector k is in row 3 + 3 i + k.
    sums : (3, B) float64, added to
        Sums of ln of the stretching factors.
    """
    for lane in range(w.shape[1]):
        for k in range(3):
            for j in range(k):
                dot = 0.0
                for i in range(3):
                    dot += w[3 + 3 * i + k, lane] * w[3 + 3 * i + j, lane]
                for i in range(3):
                    w[3 + 3 * i + k, lane] -= dot * w[3 + 3 * i + j, lane]
            norm = 0.0
            for i in range(3):
                norm += w[3 + 3 * i + k, lane] ** 2
            norm = np.sqrt(norm)
            for i in range(3):
                w[3 + 3 * i + k, lane] /= norm
            sums[k, lane] += np.log(norm)


class Heyoka:
    """An integrator of `batch` cells at a time for a tolerance; the parameter Omega1 varies from cell to cell."""

    def __init__(self, cells: Cells, tolerance: float, batch: int) -> None:
        heyoka = peer("heyoka")
        fixed = {name: float(values[0]) for name, values in cells.parameters.items()}
        states = heyoka.make_vars("p", "q", "r")
        rhs = cells.model.rhs(*states, **{**fixed, "Omega1": heyoka.par[0]})
        system = heyoka.var_ode_sys(list(zip(states, rhs, strict=True)), heyoka.var_args.vars, order=1)
        start, parameters = np.zeros((3, batch)), np.zeros((1, batch))
        self._integrator = heyoka.taylor_adaptive_batch(system, start, pars=parameters, tol=tolerance)
        self.cells, self.batch = cells, batch

    def run(self, seconds: float) -> tuple[np.ndarray, np.ndarray]:
        """Integrate all cells and return their states (n, 3) and exponents (n, 3)."""
        integrator, n = self._integrator, len(self.cells)
        frame = self.cells.frame(3)[0].T.reshape(9, 1)
        states, exponents = np.empty((n, 3)), np.empty((n, 3))
        for first in range(0, n, self.batch):
            cells = slice(first, first + self.batch)
            sums = np.zeros((3, self.batch))
            integrator.set_time(0.0)
            integrator.pars[0] = self.cells.parameters["Omega1"][cells]
            w = integrator.state
            w[:3], w[3:] = self.cells.u[cells].T, frame
            for t in range(1, round(seconds) + 1):
                integrator.propagate_until(float(t))
                orthonormalise(w, sums)
            states[cells], exponents[cells] = w[:3].T, sums.T / seconds
        return states, exponents

    def at(self, seconds: float) -> Peer:
        """Return it as a peer."""
        return Peer("heyoka", lambda: self.run(seconds)[1], seconds, len(self.cells))


def batch_sizes() -> list[int]:
    """Return the sizes of a batch worth trying: one vector of the processor, and a few."""
    size = int(peer("heyoka").recommended_simd_size())
    return [size, 2 * size, 4 * size]
