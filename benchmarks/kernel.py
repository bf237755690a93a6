"""The suite `kernel`: a step against the hardware's limit, against C, and against what most people write.

Cells of the yaw system across the map, RK4, one thread.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from benchmarks import handwritten, naive
from benchmarks.cells import Cells, yaw_cells
from benchmarks.printed import Printed, arithmetic
from benchmarks.protocol import Contender, Protocol, compare, ratios
from benchmarks.row import Measurement, Row, at_least, at_most

DT = 0.02
STEPS = 1000  # in a row, from the same start each time, so that no tangent vector overflows
BLOCK = 25
STEP_UNIT = "ns per step and cell"


def c_of_limit(protocol: Protocol) -> Measurement:
    """Share of the peak rate of FMA issue that the step in C reaches, with three vectors [%]."""
    step = handwritten.Handwritten(yaw_cells(), 3, DT, STEPS).per_step("C")
    return _of_limit(handwritten.peak(), step, handwritten.c_arithmetic(3), protocol)


def kernel_of_limit(protocol: Protocol) -> Measurement:
    """Share of the peak rate of FMA issue that the printed step reaches, with three vectors [%]."""
    peak, cells = handwritten.peak(), yaw_cells()
    step = Printed(cells, 3, DT, STEPS, 1).per_step("kernel")
    return _of_limit(peak, step, arithmetic(cells.program, 3), protocol)


def _of_limit(peak: Contender, step: Contender, operations: float, protocol: Protocol) -> Measurement:
    samples = compare([peak, step], protocol)
    values = [100 * operations * ratio / handwritten.lanes() for ratio in ratios(samples, "peak", step.name)]
    rate = 1 / float(np.median(samples["peak"]))
    note = f"{operations:g} vector operations, peak {rate:.2f} per ns"
    return Measurement(values, samples, "ns per vector FMA; " + STEP_UNIT, note, {"operations": operations})


def kernel_over_c(vectors: int, protocol: Protocol) -> Measurement:
    """Time of a printed step over that of the same arithmetic in C."""
    cells = yaw_cells()
    other, ours = handwritten.Handwritten(cells, vectors, DT, STEPS), Printed(cells, vectors, DT, STEPS, 1)
    ours()
    other()
    if not np.allclose(ours.state(), other.state(), rtol=1e-9, atol=1e-9):
        raise ValueError("C and the kernel do not compute the same")
    samples = compare([ours.per_step("kernel"), other.per_step("C")], protocol)
    note = f"{np.median(samples['kernel']):.2f} against {np.median(samples['C']):.2f} {STEP_UNIT}"
    return Measurement(ratios(samples, "kernel", "C"), samples, STEP_UNIT, note)


def instructions(_: Protocol) -> Measurement:
    """Packed arithmetic instructions of the printed step with three vectors."""
    return Measurement([arithmetic(yaw_cells(1).program, 3)], note="counted in numba's machine code")


def gram_schmidt(protocol: Protocol) -> Measurement:
    """Share of the time that one orthonormalisation per 25 steps takes [%]."""
    cells = yaw_cells()
    often = Printed(cells, 3, DT, BLOCK, STEPS // BLOCK).per_step("every 25 steps")
    seldom = Printed(cells, 3, DT, STEPS, 1).per_step("every 1000 steps")
    samples = compare([often, seldom], protocol)
    values = [100 * (1 - ratio) for ratio in ratios(samples, seldom.name, often.name)]
    return Measurement(values, samples, STEP_UNIT, f"{np.median(samples[often.name]):.2f} {STEP_UNIT} in all")


class Naive:
    """The frozen scalar loop; advances cells with three vectors, each time from their start."""

    def __init__(self, cells: Cells, dt: float, block: int, n_blocks: int) -> None:
        self.work = len(cells) * block * n_blocks
        start = np.concatenate([cells.u, cells.frame(3).reshape(len(cells), -1)], axis=1)
        self.end, self.sums = np.empty_like(start), np.zeros((len(cells), 3))
        self._arguments = (start, naive.coefficients(**cells.parameters), dt, block, n_blocks, self.end, self.sums)

    def __call__(self) -> None:
        """Advance the cells from their start."""
        naive.sweep(*self._arguments)


def naive_over_kernel(protocol: Protocol) -> Measurement:
    """Time of the scalar loop over arrays over that of the kernel, both orthonormalising every 25 steps."""
    cells = yaw_cells()
    ours, other = Printed(cells, 3, DT, BLOCK, STEPS // BLOCK), Naive(cells, DT, BLOCK, STEPS // BLOCK)
    ours()
    other()
    if not np.allclose(ours.state(), other.end[:, :3], rtol=1e-6, atol=1e-6):
        raise ValueError("the naive loop and the kernel do not compute the same")
    samples = compare([Contender("naive", other, other.work), ours.per_step("kernel")], protocol)
    note = f"{np.median(samples['naive']):.0f} against {np.median(samples['kernel']):.2f} {STEP_UNIT}"
    return Measurement(ratios(samples, "naive", "kernel"), samples, STEP_UNIT, note)


ROWS = (
    Row("c-limit", "kernel", "C / limit", "%", at_least(85), c_of_limit),
    Row(
        "kernel-c-2", "kernel", "kernel / C, 2 vectors", "x", at_most(1.10), partial(kernel_over_c, 2), needs="c-limit"
    ),
    Row(
        "kernel-c-3", "kernel", "kernel / C, 3 vectors", "x", at_most(1.10), partial(kernel_over_c, 3), needs="c-limit"
    ),
    Row("kernel-limit", "kernel", "kernel / limit", "%", at_least(80), kernel_of_limit, needs="c-limit"),
    Row("instructions", "kernel", "instructions, 3 vectors", "", at_most(245), instructions),
    Row("gram-schmidt", "kernel", "Gram-Schmidt", "%", at_most(5), gram_schmidt),
    Row("naive", "kernel", "naive numba", "x", at_least(8), naive_over_kernel, peer="naive numba loop"),
)
