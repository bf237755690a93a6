"""The layout of lanes: which rows a group holds, and packing cells into groups and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FEWEST_LANES = 16  # two vectors of AVX-512; with 8 LLVM does not vectorise
ALIGNMENT = 64  # bytes; a vector load across a cache line costs two (measured: 5 % of a step)


@dataclass(frozen=True)
class Layout:
    """Rows of W lanes that make up a group of cells; row m of lane l is at `m * lanes + l`.

    Parameters
    ----------
    dimension : int
        Number of states, D.
    vectors : int
        Number of tangent vectors, K.
    coefficients : int
        Number of per-cell coefficients, C.
    lanes : int
        Cells per group, W; a multiple of 8, at least 16.
    trace : bool
        Whether a row holds the integral of the trace of the Jacobian.
    last_from_trace : bool
        Whether the last exponent is made of that integral, without a vector of its own.
    scratch : int
        Rows that a step uses as it likes.
    phase : bool
        Whether a row holds the time, which forced systems need.
    """

    dimension: int
    vectors: int
    coefficients: int
    lanes: int = FEWEST_LANES
    trace: bool = False
    scratch: int = 0
    last_from_trace: bool = False
    phase: bool = False

    def __post_init__(self) -> None:
        if self.lanes < FEWEST_LANES or self.lanes % 8:
            raise ValueError(f"{self.lanes} lanes: must be a multiple of 8 and at least {FEWEST_LANES}")

    @property
    def frame_row(self) -> int:
        """First row of the tangent vectors; vector k, component i is at `frame_row + k * D + i`."""
        return self.dimension

    @property
    def stretch_row(self) -> int:
        """First row of the products of stretching factors."""
        return self.dimension * (1 + self.vectors)

    @property
    def trace_row(self) -> int:
        """The row of the integral of the trace, if there is one."""
        return self.stretch_row + self.vectors

    @property
    def scratch_row(self) -> int:
        """First row that a step uses as it likes."""
        return self.coefficient_row + self.coefficients

    @property
    def phase_row(self) -> int:
        """The row of the time, if there is one."""
        return self.trace_row + self.trace

    @property
    def coefficient_row(self) -> int:
        """First row of the coefficients."""
        return self.phase_row + self.phase

    @property
    def exponents(self) -> int:
        """Number of exponents that the vectors and the trace give."""
        return self.vectors + self.last_from_trace

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.scratch_row + self.scratch

    def pack(self, u: np.ndarray, frame: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        """Return the lanes of n cells; the last group is filled up with copies of the last cell.

        Parameters
        ----------
        u : (n, D) float64
        frame : (n, K, D) float64
        coefficients : (C, n) float64

        Returns
        -------
        (groups, rows, W) float64, contiguous, aligned to 64 bytes; stretching factors are 1, integrals and times 0.
        """
        n = u.shape[0]
        cells = np.minimum(np.arange(-(-n // self.lanes) * self.lanes), n - 1)
        table = np.empty((self.rows, cells.size))
        table[: self.frame_row] = u.T[:, cells]
        table[self.frame_row : self.stretch_row] = frame.reshape(n, -1).T[:, cells]
        table[self.stretch_row : self.trace_row] = 1.0
        table[self.trace_row : self.coefficient_row] = 0.0
        table[self.coefficient_row : self.scratch_row] = coefficients[:, cells]
        table[self.scratch_row :] = 0.0
        lanes = aligned_empty((cells.size // self.lanes, self.rows, self.lanes))
        lanes[...] = table.reshape(self.rows, -1, self.lanes).transpose(1, 0, 2)
        return lanes

    def set_phase(self, lanes: np.ndarray, t: float | None) -> None:
        """Set the time of all lanes, (groups, rows, W), where they have one; a kernel goes on from it step by step.

        Steps add up to the time with rounding errors, so it is set anew before each call: t = (steps mod N) dt.
        """
        if self.phase:
            lanes[:, self.phase_row] = t

    def state(self, lanes: np.ndarray, n: int) -> np.ndarray:
        """Return the state of the first n cells, (n, D), a copy."""
        return self.cells(lanes[:, : self.frame_row], n)

    def frame(self, lanes: np.ndarray, n: int) -> np.ndarray:
        """Return the tangent vectors of the first n cells, (n, K, D), a copy."""
        rows = self.cells(lanes[:, self.frame_row : self.stretch_row], n)
        return rows.reshape(n, self.vectors, self.dimension)

    def take_stretch(self, lanes: np.ndarray, n: int) -> np.ndarray:
        """Return the products of stretching factors of the first n cells, (n, K), and set them back to 1."""
        stretch = self.cells(lanes[:, self.stretch_row : self.trace_row], n)
        lanes[:, self.stretch_row : self.trace_row] = 1.0
        return stretch

    def add_growth(self, lanes: np.ndarray, growth: np.ndarray, volume: np.ndarray) -> None:
        """Add the growth of ln of the vectors' lengths, and of the volume, since it was last taken.

        Parameters
        ----------
        lanes : (groups, rows, W) float64
            Stretching factors are set back to 1, integrals to 0.
        growth : (groups, exponents, W) float64
            The last one, if made of the trace, is what the others leave of the growth of the volume.
        volume : (groups, 1, W) float64
            Untouched without a row for it.
        """
        stretch, trace = self.stretch_row, self.trace_row
        logarithms = np.log(lanes[:, stretch:trace])
        growth[:, : self.vectors] += logarithms
        lanes[:, stretch:trace] = 1.0
        if self.trace:
            swelling = lanes[:, trace : trace + 1].copy()
            volume += swelling
            if self.last_from_trace:
                growth[:, self.vectors :] += swelling - logarithms.sum(axis=1, keepdims=True)
            lanes[:, trace] = 0.0

    def cells(self, rows: np.ndarray, n: int) -> np.ndarray:
        """Return some rows of lanes, (groups, m, W), as values of the first n cells, (n, m), a copy."""
        return rows.transpose(0, 2, 1).reshape(rows.shape[0] * self.lanes, rows.shape[1])[:n].copy()


def aligned_empty(shape: tuple[int, ...]) -> np.ndarray:
    """Return an uninitialised float64 array whose data start at a multiple of 64 bytes."""
    size = int(np.prod(shape))
    buffer = np.empty(size + ALIGNMENT // 8)
    start = -(buffer.ctypes.data // 8) % (ALIGNMENT // 8)
    return buffer[start : start + size].reshape(shape)


def generic_frame(dimension: int, vectors: int) -> np.ndarray:
    """Return orthonormal vectors that are aligned with no coordinate plane, (K, D).

    A frame along the axes would never leave an invariant subspace and miss exponents; this one is the reflection
    I - 2 v v^T / v^T v with v_i the square roots of 1/2, 3/2, 5/2 ..., none of whose entries vanishes.
    """
    v = np.sqrt(np.arange(dimension) + 0.5)
    return np.asarray((np.eye(dimension) - 2.0 * np.outer(v, v) / (v @ v))[:vectors])
