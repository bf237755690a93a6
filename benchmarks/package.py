"""The suite `peers`: what else a user would pick, per simulated second and cell with three exponents."""

from __future__ import annotations

import numpy as np

from benchmarks.accuracy import UNIT, jitcode_over_kernel
from benchmarks.cells import Cells, lorenz_cells, make_cells, yaw_cells
from benchmarks.peers import Peer, dynlib, pynamicalsys
from benchmarks.printed import Printed
from benchmarks.protocol import Protocol, compare, ratios
from benchmarks.row import Measurement, Row, at_least
from quavsweep.models import load_model

BLOCK = 25
SPEEDS = (100.0, 196.4, 240.0, 400.0)  # rad/s; a sink, transient and lasting chaos, and a cell beyond


def pynamicalsys_over_kernel(protocol: Protocol) -> Measurement:
    """Time of pynamicalsys over ours, RK4 with the same step, yaw system."""
    dt, seconds = 0.02, 100.0
    cells = make_cells(load_model("quadrotor_yaw"), {"Omega1": np.array(SPEEDS)}, np.full((len(SPEEDS), 3), 1e-3))
    return _over_kernel(pynamicalsys.make_peer(cells, dt, seconds), cells, yaw_cells(), dt, protocol)


def dynlib_over_kernel(protocol: Protocol) -> Measurement:
    """Time of dynlib over ours, RK4 with the same step, Lorenz system."""
    dt, seconds = 0.01, 20.0
    cells = lorenz_cells(16)
    return _over_kernel(dynlib.make_peer(cells, dt, seconds), cells, lorenz_cells(), dt, protocol)


def _over_kernel(theirs: Peer, cells: Cells, ours: Cells, dt: float, protocol: Protocol) -> Measurement:
    """Compare a peer on `cells` with the kernel on as many cells as fit the cache."""
    blocks = round(theirs.seconds / dt / BLOCK)
    check = Printed(cells, 3, dt, BLOCK, blocks)
    check()
    a, b = theirs.exponents().mean(axis=0), check.exponents().mean(axis=0)
    kernel = Printed(ours, 3, dt, BLOCK, blocks).per_second("kernel")
    samples = compare([theirs.per_second(), kernel], protocol)
    microseconds = [f"{np.median(samples[name]) / 1e3:.3g}" for name in (theirs.name, "kernel")]
    note = (
        f"{microseconds[0]} against {microseconds[1]} us per simulated second and cell; mean exponents over "
        f"{theirs.seconds:g} s differ by {np.abs(a - b).max():.1g}, their sums by {abs(a.sum() - b.sum()):.1g}"
    )
    detail = {"exponents": {theirs.name: a.tolist(), "kernel": b.tolist()}}
    return Measurement(ratios(samples, theirs.name, "kernel"), samples, UNIT, note, detail)


ROWS = tuple(
    Row(key, "peers", title, "x", at_least(bound), measure, peer=title)
    for key, title, bound, measure in (
        ("pynamicalsys", "pynamicalsys, RK4", 150, pynamicalsys_over_kernel),
        ("dynlib", "dynlib, RK4, Lorenz", 60, dynlib_over_kernel),
        ("jitcode", "JiTCODE, dop853 1e-9", 50, jitcode_over_kernel),
    )
)
