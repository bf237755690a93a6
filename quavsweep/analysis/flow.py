"""Runs of compiled kernels from many states at once: the stretch that follows, and how its end depends on its start."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from threading import Lock

import numpy as np

from quavsweep.analysis.equilibrium import vector_field
from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.layout import Layout, aligned_empty
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program
from quavsweep.kernels.step import choose_layout

BUFFER_BYTES = 2**22  # of recorded states that are looked at together

_COMPILING = Lock()  # tiles run in threads, and two of them must not compile one kernel at the same time


class Flow:
    """The numerical flow of a program; kernels are compiled when they are first needed.

    A cell's numbers do not depend on the cells beside it. Runs of a forced system start at phase 0.

    Parameters
    ----------
    program : Program
    lanes : int
        Cells per group of the kernels.
    """

    def __init__(self, program: Program, lanes: int) -> None:
        self.program = program
        self._lanes = lanes

    def tangent(
        self, method: ButcherTable, u: np.ndarray, parameters: Sequence[np.ndarray], dt: np.ndarray, steps: int
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return where states go, the derivative of that by where they began, and the growth of volume.

        Parameters
        ----------
        u : (n, D) float64
        parameters : sequence of (n,) arrays
        dt : (n,) float64
            Steps, each cell its own.
        steps : int
            Their number, the same for all.

        Returns
        -------
        end : (n, D) float64
        derivative : (n, D, D) float64
        volume : (n,) float64
            Integral of the divergence, dimensionless.
        """
        n, dimension = u.shape
        layout = choose_layout(self.program, method, dimension, self._lanes, last_from_trace=True)
        frame = np.broadcast_to(np.eye(dimension), (n, dimension, dimension))
        lanes = self._pack(layout, method, u, frame, parameters, dt)
        self._kernel(method, layout, dense=False)(lanes.reshape(-1), 0, len(lanes), 1, steps)
        volume = layout.cells(lanes[:, layout.trace_row : layout.trace_row + 1], n)[:, 0]
        return layout.state(lanes, n), layout.frame(lanes, n).transpose(0, 2, 1).copy(), volume

    def record(
        self, method: ButcherTable, u: np.ndarray, parameters: Sequence[np.ndarray], dt: np.ndarray, steps: int
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the states before the first step and after each, for some cells after the other.

        Yields
        ------
        cells : (m,) int
        states : (1 + steps, D, m) float64
        """
        n = len(u)
        layout = choose_layout(self.program, method, 0, self._lanes)
        lanes = self._pack(layout, method, u, np.zeros((n, 0, u.shape[1])), parameters, dt)
        kernel = self._kernel(method, layout, dense=True)
        shape = (steps + 1, layout.dimension, layout.lanes)
        at_once = max(1, BUFFER_BYTES // (8 * shape[0] * shape[1] * shape[2]))
        for first in range(0, len(lanes), at_once):
            last = min(first + at_once, len(lanes))
            buffer = aligned_empty((last - first, *shape))
            kernel(lanes.reshape(-1), first, last, 1, steps, buffer.reshape(-1))
            cells = np.arange(first * layout.lanes, min(n, last * layout.lanes))
            yield cells, buffer.transpose(1, 2, 0, 3).reshape(steps + 1, layout.dimension, -1)[:, :, : cells.size]

    def velocity(self, u: np.ndarray, parameters: Sequence[np.ndarray]) -> np.ndarray:
        """Return the derivatives of states (n, D), exactly as the program has them."""
        return vector_field(self.program, u, self.program.coefficient_values(parameters))[0]

    def _pack(
        self,
        layout: Layout,
        method: ButcherTable,
        u: np.ndarray,
        frame: np.ndarray,
        parameters: Sequence[np.ndarray],
        dt: np.ndarray,
    ) -> np.ndarray:
        return layout.pack(u, frame, self.program.coefficient_values(parameters, float(method.unit) * dt))

    def _kernel(self, method: ButcherTable, layout: Layout, dense: bool) -> Callable[..., None]:
        with _COMPILING:
            return make_advance(self.program, method, layout, dense, orthonormal=False)
