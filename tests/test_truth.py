"""What must be true of both planes of the paper: volume contraction, exponents of sinks, rims of certificates.

These take minutes and are left out of a plain run: `pytest -m slow tests/test_truth.py`; `-s` prints the figures.
What else is judged on them are rows of `python -m tests.truth`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from quavsweep.analysis.certificate import Shape
from quavsweep.analysis.equilibrium import eigensystem, vector_field
from quavsweep.classify.growth import growth_of
from quavsweep.codes import Certificate, Region
from quavsweep.grid import Tile
from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.layout import Layout
from quavsweep.plan import cell_values, make_plan
from quavsweep.result import Result, open_result
from quavsweep.sweep import run_sweep
from tests.truth.laboratory import changed, stored_evidence
from tests.truth.plane import PLANES, THUMBNAIL, plane

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1200)]


def _sum_error(result: Result) -> np.ndarray:
    """Return the raw sums of the exponents less the divergence of the equations, (cells,)."""
    sweep = result.sweep
    p = {**sweep.parameters, **sweep.grid.coordinates(0, sweep.grid.size)}
    divergence = -(p["k4"] / p["Ix"] + p["k5"] / p["Iy"] + p["k6"] / p["Iz"])
    return np.asarray(result["lyapunov_raw"].sum(axis=-1).ravel() - divergence)


@pytest.mark.parametrize("name", PLANES)
def test_raw_sums_equal_the_divergence_in_every_cell(name: str, tmp_path: Path) -> None:
    result = open_result(run_sweep(plane(name, None, "stop_early=false"), tmp_path))
    worst = np.abs(_sum_error(result)).max()
    print(f"\n{name}: {result.sweep.grid.size} cells, worst sum error {worst:.2e}")
    assert worst < 1e-7


@pytest.mark.parametrize("name", PLANES)
def test_the_sum_error_falls_with_the_fourth_power_of_the_step(name: str, tmp_path: Path) -> None:
    worst = []
    for n, dt in enumerate((0.02, 0.01, 0.005)):
        same_times = f"measures.lyapunov.block={25 * 2**n}"  # between two orthonormalisations
        sweep = changed(plane(name, (31, 15), "stop_early=false"), f"integrate.dt={dt}", same_times)
        result = open_result(run_sweep(sweep, tmp_path / str(n)))
        assert result.sweep.clock.duration == 3000
        worst.append(np.abs(_sum_error(result)).max())
    ratios = worst[0] / worst[1], worst[1] / worst[2]
    print(f"\n{name}: worst {worst[0]:.2e}, {worst[1]:.2e}, {worst[2]:.2e}; falls by {ratios[0]:.1f}, {ratios[1]:.1f}")
    assert 11 <= ratios[0] <= 16
    assert 13 <= ratios[1] <= 17


@pytest.mark.parametrize("name", PLANES)
def test_exponents_of_sinks_are_eigenvalues(name: str, tmp_path: Path) -> None:
    """Against a Jacobian by complex steps from the model's own function."""
    sweep = plane(name, THUMBNAIL)
    result = open_result(run_sweep(sweep, tmp_path))
    cells = np.flatnonzero(result["region"].ravel() == Region.SINK)
    assert cells.size > 1000
    parameters, _ = cell_values(sweep, Tile(0, 0, sweep.grid.size))
    worst = 0.0
    for cell in cells:
        p = [values[cell] for values in parameters]
        u = result["equilibrium"].reshape(-1, 3)[cell]
        jacobian = np.empty((3, 3))
        for j in range(3):
            moved = u.astype(complex)
            moved[j] += 1e-30j
            jacobian[:, j] = [complex(f).imag / 1e-30 for f in sweep.model.rhs(*moved, *p)]
        values, right = np.linalg.eig(jacobian)
        left = np.linalg.inv(right)
        condition = (np.linalg.norm(right, axis=0) * np.linalg.norm(left, axis=1)).max()
        miss = np.abs(np.sort(values.real)[::-1] - result["lyapunov"].reshape(-1, 3)[cell]).max()
        worst = max(worst, miss / condition)
    print(f"\n{name}: {cells.size} sinks, worst miss {worst:.1e} x condition")
    assert worst < 1e-10


@pytest.mark.parametrize("name", PLANES)
def test_raw_exponents_of_sinks_agree_with_the_exact_ones(name: str, tmp_path: Path) -> None:
    sweep = plane(name, THUMBNAIL, "stop_early=false")
    run_sweep(sweep, tmp_path)
    evidence, clock = stored_evidence(tmp_path, sweep), sweep.clock
    sink = np.flatnonzero(evidence["certificate"] == Certificate.SINK)
    settled = evidence["settled_steps"][sink]
    # The look before is the last one outside; whoever was inside at the end of the transient settled within it.
    within = evidence["certified_steps"][sink] <= clock.transient_segments * clock.segment_steps
    first = np.where(within, clock.transient_segments * clock.segment_batches, settled // clock.batch_steps)
    growth = growth_of({name: values[sink] for name, values in evidence.items()}, clock)
    average = growth.over((first, np.full_like(first, clock.segments * clock.segment_batches)))
    error = np.where(np.isfinite(average.error), average.error, 0.0)
    share = np.abs(average.rate - evidence["eigenvalue_re"][sink]) / np.maximum(3 * error, 5 / average.time[:, None])
    print(f"\n{name}: {within.sum()} sinks settled within the transient, worst {share[within].max():.2f} of what is")
    print(f"allowed; {(~within).sum()} later ones, worst {share[~within].max():.2f}")
    assert share.max() <= 1.0


@pytest.mark.parametrize("name", PLANES)
def test_orbits_from_the_rims_of_certificates_fall_in(name: str, tmp_path: Path) -> None:
    """100 orbits from the rim of each of 10 cells per plane, at the largest level that a certificate accepts."""
    sweep = plane(name, THUMBNAIL)
    run_sweep(sweep, tmp_path)
    evidence = stored_evidence(tmp_path, sweep)
    sinks = np.flatnonzero(evidence["certificate"] == Certificate.SINK)
    rng = np.random.default_rng(11)
    cells = np.sort(rng.choice(sinks, 10, replace=False))
    program = make_plan(sweep, 16).program
    parameters, _ = cell_values(sweep, Tile(0, 0, sweep.grid.size))
    coefficients = program.coefficient_values([values[cells] for values in parameters])
    point = evidence["equilibrium"][cells]
    jacobian = vector_field(program, point, coefficients)[1]
    spectrum, vectors = eigensystem(jacobian)
    shape = Shape.around(jacobian, spectrum, vectors)
    low, high = np.full(10, 1e-9), np.full(10, 1e3)
    for _ in range(60):
        middle = np.sqrt(low * high)
        good = shape.decreases(program, sweep.method, sweep.clock.dt, point, coefficients, middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    directions = rng.normal(size=(10, 100, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    start = point[:, None] + np.einsum("nij,nkj->nki", shape.to_x, low[:, None, None] * directions)
    layout = Layout(3, 0, len(coefficients))
    scaled = program.coefficient_values([v[cells] for v in parameters], sweep.method.time_unit(sweep.clock.dt))
    lanes = layout.pack(start.reshape(-1, 3), np.empty((1000, 0, 3)), np.repeat(scaled, 100, axis=1))
    advance = make_advance(program, sweep.method, layout)
    before = np.repeat(low, 100) * (1 + 1e-12)
    for _ in range(40):
        advance(lanes.reshape(-1), 0, lanes.shape[0], 1, 2500)
        away = layout.state(lanes, 1000).reshape(10, 100, 3) - point[:, None]
        level = np.linalg.norm(np.einsum("nij,nkj->nki", shape.to_y, away), axis=2).ravel()
        assert ((level < before) | (level < 1e-12)).all()
        before = np.maximum(level, 1e-12)
    print(f"\n{name}: levels of the rims {low.min():.3f} to {low.max():.3f}, after 2000 s at most {level.max():.1e}")
    assert level.max() < 1e-9
