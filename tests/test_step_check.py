"""The error that the step causes: estimated rightly, said, and without influence on any result."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quavsweep.classify import classify
from quavsweep.codes import Region
from quavsweep.config import Sweep, parse_sweep
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.models import load_model
from quavsweep.plan import make_plan
from quavsweep.step_check import check_step, regular_cells
from quavsweep.sweep import run_sweep
from tests.conftest import LORENZ, YAW

CONFIG = """\
name: check
model: quadrotor_yaw
initial: {{p: 0.5, q: -0.4, r: 1}}
axes: {{Omega1: {{values: [100, 120, 140]}}}}
integrate: {{method: {method}, dt: {dt}, transient: 100, duration: 400{more}}}
measures: {{{measures}}}
"""
LYAPUNOV = "lyapunov: {exponents: 3, block: 25}"


def _config(method: str = "rk4", dt: float = 0.05, more: str = "", measures: str = LYAPUNOV) -> str:
    return CONFIG.format(method=method, dt=dt, more=more, measures=measures)


@pytest.mark.parametrize("measures", [LYAPUNOV, "", "peak: {of: [p]}"])
@pytest.mark.parametrize(("method", "dt"), [("rk4", 0.05), ("dp8", 0.4)])
def test_the_estimate_is_the_true_error(method: str, dt: float, measures: str) -> None:
    sweep = parse_sweep(_config(method, dt, measures=measures))
    plan = make_plan(sweep, 16)
    found = check_step(plan, Tile(0, 0, 3), np.array([True, False, True]), 1e9, lambda: False)
    assert found is not None
    assert found.cells == 2
    assert found.time == pytest.approx(100)
    model, end = load_model("quadrotor_yaw"), []
    for omega in (100, 140):
        p = [*({**model.defaults, "Omega1": omega}).values()]
        u = (0.5, -0.4, 1.0)
        exact = solve_ivp(lambda t, x, p=p: model.rhs(*x, *p), (0, found.time), u, "DOP853", rtol=1e-13, atol=1e-15)
        end.append(exact.y[:, -1])
    coarse = parse_sweep(_config(method, dt, measures=f"orbit: {{every: {found.time}, until: {found.time}}}"))
    orbit = integrate_tile(make_plan(coarse, 16), Tile(0, 0, 3), lambda: False)["orbit"][[0, 2], -1]
    size = np.maximum(np.abs([0.5, -0.4, 1.0]), np.abs(end).max(axis=0))
    errors = (np.abs(orbit - end) / size).max(axis=1)
    assert found.largest == pytest.approx(errors.max(), rel=0.2)
    assert found.median == pytest.approx(np.median(errors), rel=0.2)


def test_short_runs_are_checked_over_less_time() -> None:
    plan = make_plan(parse_sweep(_config()), 16)
    regular = np.array([True, True, True])
    short = check_step(plan, Tile(0, 0, 3), regular, 3 * 10_000, lambda: False)
    assert short is not None
    assert short.time == pytest.approx(25 * 0.05)


def test_where_nothing_is_regular_nothing_is_said() -> None:
    plan = make_plan(parse_sweep(_config()), 16)
    assert check_step(plan, Tile(0, 0, 3), np.zeros(3, dtype=bool), 1e9, lambda: False) is None
    assert check_step(plan, Tile(0, 0, 3), np.ones(3, dtype=bool), 1e9, lambda: True) is None


def _run(path: Path, out: Path) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-m", "quavsweep", "run", str(path), "--out", str(out), "--no-plot"]
    return subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)


def test_a_run_says_the_error_and_warns_beyond_the_tolerance(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(_config(more=", tolerance: 1e-12"))
    done = _run(path, tmp_path / "a")
    assert "integrate.tolerance is 1e-12: a shorter integrate.dt" in done.stderr
    assert "error by dt" in done.stdout
    record = json.loads((tmp_path / "a" / "run.json").read_text())["starts"][-1]
    assert record["step_error"]["cells"] == 3
    assert record["step_error"]["median"] > 1e-12
    path.write_text(_config())
    done = _run(path, tmp_path / "b")
    assert "warning" not in done.stderr
    assert "error by dt" in done.stdout
    assert (tmp_path / "a" / "result.h5").read_bytes() == (tmp_path / "b" / "result.h5").read_bytes()


def test_another_tolerance_integrates_nothing_anew(tmp_path: Path) -> None:
    run_sweep(parse_sweep(_config()), tmp_path)
    seen = []
    run_sweep(parse_sweep(_config(more=", tolerance: 0.5")), tmp_path, observe=lambda p: seen.append(p.cells_run))
    assert set(seen) == {0}


def test_cells_that_were_chaotic_before_the_first_look_do_not_count(make_sweep: Callable[..., Sweep]) -> None:
    """Cycles of the Lorenz system, some of them reached through chaos that is over by t = 100."""
    sweep = make_sweep(
        LORENZ,
        ("start: 0.5, stop: 600, num: 60", "start: 60, stop: 200, num: 200"),
        ("dt: 0.02", "dt: 0.005"),
        ("block: 5", "block: 20"),
        ("transient: 20, duration: 80", "transient: 100, duration: 300"),
    )
    plan, tile = make_plan(sweep, 16), Tile(0, 0, sweep.grid.size)
    evidence = integrate_tile(plan, tile, lambda: False)
    labels = classify(sweep, evidence)
    regular = regular_cells(sweep, evidence, labels)
    calm = np.isin(labels["region"], (Region.SINK, Region.PERIODIC)) & (labels["was_chaotic"] == 0)
    assert regular.any()
    assert not regular[~calm].any()
    found, mixed = (check_step(plan, tile, cells, 1e9, lambda: False) for cells in (regular, calm & ~regular))
    assert found is not None
    assert mixed is not None
    assert found.median < 0.05
    assert mixed.median > 10 * found.median


def test_without_exponents_those_that_settled_first_count(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("measures: {lyapunov: {exponents: 3, block: 25}}", "measures: {}"))
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, sweep.grid.size), lambda: False)
    labels = classify(sweep, evidence)
    regular, settle = regular_cells(sweep, evidence, labels), labels["settle_time"]
    assert regular.any()
    assert settle[regular].max() < np.nanmax(settle)
    evidence["certificate"][:] = 0
    assert not regular_cells(sweep, evidence, labels).any()
