"""The same arithmetic in C with vector types, and the peak rate of fused multiply-adds, as contenders."""

from __future__ import annotations

import ctypes

import numpy as np

from benchmarks.assembly import kinds
from benchmarks.c_source import library, loop, vector_bytes
from benchmarks.cells import Cells
from benchmarks.naive import coefficients
from benchmarks.protocol import Contender
from quavsweep.kernels.layout import aligned_empty

CHAINS = 12  # of the C source
ROUNDS = 1_000_000


class Handwritten:
    """The yaw system's step in C; advances cells by `steps` steps of RK4, each time from their start."""

    def __init__(self, cells: Cells, vectors: int, dt: float, steps: int) -> None:
        self.cells, self.steps = cells, steps
        self._advance = library("step_yaw.c", VECTORS=vectors).advance
        self._advance.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)
        scaled = 0.5 * dt * coefficients(**cells.parameters)
        table = np.concatenate([cells.u, cells.frame(vectors).reshape(len(cells), -1), scaled], axis=1).T
        self._fresh = table.reshape(len(table), -1, lanes()).transpose(1, 0, 2)
        self._lanes = aligned_empty(self._fresh.shape)
        self._arguments = (self._lanes.ctypes.data, self._lanes.shape[0], steps)

    def __call__(self) -> None:
        """Advance the cells from their start."""
        self._lanes[...] = self._fresh
        self._advance(*self._arguments)

    def state(self) -> np.ndarray:
        """Return the states, (n, 3)."""
        return self._lanes[:, :3].transpose(0, 2, 1).reshape(-1, 3)

    def per_step(self, name: str) -> Contender:
        """Return it as a contender that is timed per step and cell."""
        return Contender(name, self, self.steps * len(self.cells))


def lanes() -> int:
    """Return how many numbers a vector of the processor holds."""
    return vector_bytes() // 8


def peak() -> Contender:
    """Return the contender that does nothing but fused multiply-adds, timed per vector operation."""
    run = library("peak_fma.c").peak
    run.argtypes, run.restype = (ctypes.c_size_t,), ctypes.c_double
    return Contender("peak", lambda: run(ROUNDS), ROUNDS * CHAINS)


def c_arithmetic(vectors: int) -> int:
    """Return how many packed arithmetic instructions the C compiler made of a step of one vector of cells."""
    return kinds(loop("step_yaw.c", VECTORS=vectors))["pd"]
