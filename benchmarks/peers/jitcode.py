"""JiTCODE: C code of the state and three tangent vectors, compiled by gcc, driven by SciPy's dop853."""

from __future__ import annotations

import contextlib
import tempfile
from typing import Any

import numpy as np

from benchmarks.c_source import gcc
from benchmarks.cells import Cells
from benchmarks.peers import Peer, peer

INTERVAL = 20.0  # s between two orthonormalisations: longer gains nothing, 1 s takes three times as long


def packages() -> tuple[Any, Any]:
    """Return JiTCODE and the algebra that it is built on, if gcc is there too."""
    gcc()
    return peer("jitcode"), peer("symengine")


class JitCode:
    """The compiled system with dop853 at a relative and absolute tolerance; Omega1 varies from cell to cell."""

    def __init__(self, cells: Cells, tolerance: float) -> None:
        jitcode, symengine = packages()
        speed = symengine.Symbol("Omega1")
        fixed = {name: float(values[0]) for name, values in cells.parameters.items()}
        rhs = cells.model.rhs(*(jitcode.y(i) for i in range(3)), **{**fixed, "Omega1": speed})
        self._system = jitcode.jitcode_lyap(
            [symengine.sympify(f) for f in rhs], n_lyap=3, control_pars=[speed], verbose=False
        )
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), contextlib.redirect_stdout(None):
            # It compiles by setuptools, which would read a project file in the current folder.
            self._system.set_integrator("dop853", rtol=tolerance, atol=tolerance)
        self.cells = cells

    def run(self, seconds: float) -> tuple[np.ndarray, np.ndarray]:
        """Integrate all cells and return their states (n, 3) and exponents (n, 3)."""
        system, states, exponents = self._system, [], []
        times = np.linspace(0.0, seconds, 1 + round(seconds / INTERVAL))[1:]
        for u, speed in zip(self.cells.u, self.cells.parameters["Omega1"], strict=True):
            system.set_parameters([speed])
            system.set_initial_value(u, 0.0)
            growth = [system.integrate(t)[1] for t in times]
            states.append(np.array(system.y[:3]))
            exponents.append(np.mean(growth, axis=0))
        return np.array(states), np.array(exponents)

    def at(self, seconds: float) -> Peer:
        """Return it as a peer."""
        return Peer("JiTCODE", lambda: self.run(seconds)[1], seconds, len(self.cells))
