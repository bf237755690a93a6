"""The suite `dimension`: a kernel of twelve states with twelve vectors (Lorenz 96) against one of three with three."""

from __future__ import annotations

import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.assembly import compile_afresh
from benchmarks.cells import Cells, make_cells, yaw_cells
from benchmarks.lorenz96 import MODEL
from benchmarks.printed import Printed, arithmetic, make_layout
from benchmarks.protocol import Protocol, compare, ratios
from benchmarks.row import Measurement, Row, at_most
from quavsweep.kernels.derive import derive
from quavsweep.kernels.method import RK4
from quavsweep.kernels.printer import print_kernel

DT = 0.01
STEPS = 500
BLOCK = 25


def twelve_cells(n: int = 64) -> Cells:
    """Return chaotic cells of the system with twelve states."""
    u = np.random.default_rng(0).uniform(-1.0, 1.0, (n, 12))
    return make_cells(MODEL, {"F": np.linspace(6.0, 9.0, n)}, u)


def per_operation(protocol: Protocol) -> Measurement:
    """Time per arithmetic instruction of the step with twelve states over that with three."""
    wide, narrow = twelve_cells(), yaw_cells()
    operations = arithmetic(wide.program, 12), arithmetic(narrow.program, 3)
    contenders = [
        Printed(wide, 12, DT, BLOCK, STEPS // BLOCK).per_step("12 states"),
        Printed(narrow, 3, DT, BLOCK, STEPS // BLOCK).per_step("3 states"),
    ]
    samples = compare(contenders, protocol)
    values = [ratio * operations[1] / operations[0] for ratio in ratios(samples, "12 states", "3 states")]
    note = f"{operations[0]:g} and {operations[1]:g} operations, {np.median(samples['12 states']):.0f} and "
    note += f"{np.median(samples['3 states']):.2f} ns per step and cell"
    return Measurement(values, samples, "ns per step and cell", note, {"operations": operations})


def compile_time(vectors: int, protocol: Protocol) -> Measurement:
    """Time from the equations of twelve states to machine code [s], with nothing in a cache."""
    seconds = []
    for _ in range(1 if protocol.quick else protocol.samples):
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            program = derive(MODEL)
            compile_afresh(print_kernel(program, RK4, make_layout(program, vectors)), Path(folder))
            seconds.append(time.perf_counter() - began)
    return Measurement(seconds, {"compile": seconds}, "s", "derived, printed and compiled afresh")


ROWS = (
    Row("operation-12", "dimension", "per operation, D = 12 / 3", "x", at_most(3), per_operation),
    Row("compile-12", "dimension", "compile, D = 12", "s", at_most(30), partial(compile_time, 12)),
)
