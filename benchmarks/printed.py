"""The printed kernel as a contender; the one place where the benchmarks call it."""

from __future__ import annotations

import numpy as np

from benchmarks.assembly import kinds, printed_loop
from benchmarks.cells import Cells
from benchmarks.protocol import Contender
from quavsweep.kernels.compiler import default_lanes, make_advance
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.method import RK4, ButcherTable
from quavsweep.kernels.printer import print_kernel, step_operations
from quavsweep.kernels.program import Program
from quavsweep.kernels.step import choose_layout


def make_layout(program: Program, vectors: int, method: ButcherTable = RK4) -> Layout:
    """Return the layout that a sweep would use."""
    return choose_layout(program, method, vectors, default_lanes())


class Printed:
    """A printed kernel that advances cells by a number of blocks, each time from their start.

    Parameters
    ----------
    cells : Cells
    vectors : int
        Tangent vectors, K.
    dt : float
        Step.
    block, n_blocks : int
        Steps between two orthonormalisations, and blocks per call.
    method : ButcherTable
    """

    def __init__(
        self, cells: Cells, vectors: int, dt: float, block: int, n_blocks: int, method: ButcherTable = RK4
    ) -> None:
        self.cells, self.steps, self.seconds = cells, block * n_blocks, block * n_blocks * dt
        self._layout = make_layout(cells.program, vectors, method)
        self._advance = make_advance(cells.program, method, self._layout)
        rows = cells.u, cells.frame(vectors), cells.coefficients(method.time_unit(dt))
        self._fresh, self._lanes = self._layout.pack(*rows), self._layout.pack(*rows)
        self._flat = self._lanes.reshape(-1)
        self._arguments = (0, self._lanes.shape[0], n_blocks, block)

    def __call__(self) -> None:
        """Advance the cells from their start."""
        self._lanes[...] = self._fresh
        self._advance(self._flat, *self._arguments)

    def state(self) -> np.ndarray:
        """Return the states, (n, D)."""
        return self._layout.state(self._lanes, len(self.cells))

    def exponents(self) -> np.ndarray:
        """Return the exponents of the stretch of time that a call covers, (n, K)."""
        first, vectors = self._layout.stretch_row, self._layout.vectors
        stretch = self._lanes[:, first : first + vectors].transpose(0, 2, 1).reshape(-1, vectors)
        return np.asarray(np.log(stretch[: len(self.cells)]) / self.seconds)

    def per_step(self, name: str) -> Contender:
        """Return it as a contender that is timed per step and cell."""
        return Contender(name, self, self.steps * len(self.cells))

    def per_second(self, name: str) -> Contender:
        """Return it as a contender that is timed per simulated second and cell."""
        return Contender(name, self, self.seconds * len(self.cells))


def arithmetic(program: Program, vectors: int, method: ButcherTable = RK4) -> float:
    """Return how many arithmetic instructions a step of one vector of cells takes.

    They are counted in the form of the step that is one loop over lanes. The compiler may have put the steps of several
    vectors of cells into one turn of it; how many is told by the number of operations that the equations need.
    """
    joint = Layout(program.dimension, vectors, len(program.coefficients), default_lanes())
    count = kinds(printed_loop(print_kernel(program, method, joint))).total()
    return count / max(1, round(count / step_operations(program, method, joint)))
