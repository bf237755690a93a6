"""Runs of compiled kernels from many states at once: the stretch that follows, and how its end depends on its start."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from threading import Lock

import numpy as np

from quavsweep.analysis.equilibrium import vector_field
from quavsweep.analysis.event import After
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
        self._kernels: dict[tuple[str, Layout, bool], Callable[..., None]] = {}

    def tangent(
        self, method: ButcherTable, u: np.ndarray, parameters: Sequence[np.ndarray], time: np.ndarray, steps: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return where states go, the derivative of that by where they began, and the growth of volume.

        Parameters
        ----------
        u : (n, D) float64
        parameters : sequence of (n,) arrays
        time : (n,) float64
            How long each cell runs [time unit of the model].
        steps : (n,) int
            In how many steps; cells with the same number share calls of the kernel.

        Returns
        -------
        end : (n, D) float64
        derivative : (n, D, D) float64
        volume : (n,) float64
            Integral of the divergence, dimensionless.
        """
        n, dimension = u.shape
        layout = choose_layout(self.program, method, dimension, self._lanes, trace=True)
        kernel = self._kernel(method, layout, dense=False)
        frame = np.broadcast_to(np.eye(dimension), (n, dimension, dimension))
        coefficients = self._coefficients(method, parameters, time / steps)
        end, derivative, volume = np.empty((n, dimension)), np.empty((n, dimension, dimension)), np.empty(n)
        for count in np.unique(steps):
            cells = np.flatnonzero(steps == count)
            lanes = layout.pack(u[cells], frame[cells], coefficients[:, cells])
            kernel(lanes.reshape(-1), 0, len(lanes), 1, int(count))
            end[cells] = layout.state(lanes, cells.size)
            derivative[cells] = layout.frame(lanes, cells.size).transpose(0, 2, 1)
            volume[cells] = layout.cells(lanes[:, layout.trace_row : layout.trace_row + 1], cells.size)[:, 0]
        return end, derivative, volume

    def record(
        self, method: ButcherTable, u: np.ndarray, parameters: Sequence[np.ndarray], time: np.ndarray, steps: np.ndarray
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the states before the first step and after each, for some cells after the other.

        Parameters are those of `tangent`.

        Yields
        ------
        cells : (m,) int
            Cells with the same number of steps.
        states : (1 + steps, D, m) float64
        """
        layout = choose_layout(self.program, method, 0, self._lanes)
        kernel = self._kernel(method, layout, dense=True)
        coefficients = self._coefficients(method, parameters, time / steps)
        for count in np.unique(steps):
            group = np.flatnonzero(steps == count)
            lanes = layout.pack(u[group], np.zeros((group.size, 0, u.shape[1])), coefficients[:, group])
            shape = (int(count) + 1, layout.dimension, layout.lanes)
            at_once = max(1, BUFFER_BYTES // (8 * shape[0] * shape[1] * shape[2]))
            for first in range(0, len(lanes), at_once):
                last = min(first + at_once, len(lanes))
                buffer = aligned_empty((last - first, *shape))
                kernel(lanes.reshape(-1), first, last, 1, int(count), buffer.reshape(-1))
                cells = group[first * layout.lanes : last * layout.lanes]
                yield cells, buffer.transpose(1, 2, 0, 3).reshape(*shape[:2], -1)[:, :, : cells.size]

    def steps_from(self, method: ButcherTable, u: np.ndarray, parameters: Sequence[np.ndarray]) -> After:
        """Return what steps of an autonomous system from states (n, D) end in."""

        def after(time: np.ndarray, which: np.ndarray) -> np.ndarray:
            if not which.size:
                return np.empty((u.shape[1], 0))
            ends = self.record(method, u[which], [p[which] for p in parameters], time, np.ones_like(which))
            return np.concatenate([states[1] for _, states in ends], axis=1)

        return after

    def velocity(self, u: np.ndarray, parameters: Sequence[np.ndarray]) -> np.ndarray:
        """Return the derivatives of states (n, D), exactly as the program has them."""
        return vector_field(self.program, u, self.program.coefficient_values(parameters))[0]

    def _coefficients(self, method: ButcherTable, parameters: Sequence[np.ndarray], dt: np.ndarray) -> np.ndarray:
        """Return the coefficients of kernels for a step of its own for each cell, (C, n)."""
        return self.program.coefficient_values(parameters, float(method.unit) * dt)

    def _kernel(self, method: ButcherTable, layout: Layout, dense: bool) -> Callable[..., None]:
        key = (method.name, layout, dense)
        if key not in self._kernels:
            with _COMPILING:
                self._kernels[key] = make_advance(self.program, method, layout, dense, orthonormal=False)
        return self._kernels[key]
