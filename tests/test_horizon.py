"""Evidence cut off at a time: what a run of that length leaves."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from quavsweep.classify import classify
from quavsweep.codes import Certificate, Region, Status
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.grid import Tile
from quavsweep.horizon import truncated
from quavsweep.integrate import integrate_tile
from quavsweep.measures import Evidence
from quavsweep.plan import make_plan
from quavsweep.plot import draw, make_figure
from quavsweep.result import Result, open_result
from quavsweep.sweep import run_sweep
from tests.conftest import LORENZ, YAW

LENGTHS = (
    "transient: 200, duration: 600}\nmeasures: {lyapunov: {exponents: 3, block: 25}}",
    "transient: 1000, duration: %d}\nmeasures: {lyapunov: {exponents: 3, block: 25, batch: 62.5}}",
)
SAME = (
    *("region", "status", "time_used", "lyapunov", "lyapunov_raw", "lyapunov_se", "growth_departure"),
    *("birkhoff_digits", "was_chaotic", "chaotic_until", "lyapunov_chaotic", "lyapunov_chaotic_se"),
    *("settle_time", "sum_error", "zero_error"),
)

FORCED = """
name: forced
model: duffing
initial: {x: 1, v: 0}
integrate: {dt: 0.05, transient: 300, duration: 900}
"""


def _integrated(sweep: Sweep) -> Evidence:
    return integrate_tile(make_plan(sweep, 16), Tile(0, 0, sweep.grid.size), lambda: False)


@pytest.mark.parametrize("stop_early", ["true", "false"])
def test_a_horizon_is_a_run_of_that_length(make_sweep: Callable[..., Sweep], stop_early: str) -> None:
    def sweep_of(duration: int) -> Sweep:
        return make_sweep(YAW + f"stop_early: {stop_early}\n", (LENGTHS[0], LENGTHS[1] % duration))

    sweep = sweep_of(3000)
    evidence = _integrated(sweep)
    before = {name: values.copy() for name, values in evidence.items()}
    for duration in (250, 1000, 2250):
        shorter = sweep_of(duration)
        real = classify(shorter, _integrated(shorter))
        cut = truncated(sweep, evidence, shorter.clock.steps)
        for name in SAME:
            np.testing.assert_array_equal(classify(sweep, cut)[name], real[name], err_msg=f"{name} at {duration}")
        went_on = evidence["steps"] > shorter.clock.steps
        assert went_on.any()
        assert np.isnan(cut["state"][went_on]).all()
        np.testing.assert_array_equal(cut["state"][~went_on], evidence["state"][~went_on])
    for name, values in before.items():
        np.testing.assert_array_equal(evidence[name], values)
    whole = truncated(sweep, evidence, sweep.clock.steps)
    for name, values in whole.items():
        np.testing.assert_array_equal(values, evidence[name], err_msg=name)


def test_what_diverges_later_has_not_diverged_yet(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(LORENZ)
    evidence = _integrated(sweep)
    steps = sweep.clock.segment_steps
    last = sweep.clock.segments
    evidence["status"][0], evidence["steps"][0] = Status.DIVERGED, last * steps
    evidence["growth_total"][0, -1] = np.nan
    evidence["status"][1], evidence["steps"][1] = Status.FRAME_DEGENERATE, last * steps
    evidence["growth_total"][1] = np.where(np.arange(last) < last - 2, 0.0, np.nan)[:, None]
    early = truncated(sweep, evidence, (last - 1) * steps)
    assert early["status"][0] == Status.TIME_OVER
    assert early["status"][1] == Status.FRAME_DEGENERATE
    assert truncated(sweep, evidence, (last - 2) * steps)["status"][1] == Status.TIME_OVER
    gone = (evidence["status"] == Status.DIVERGED) & (evidence["steps"] <= (last - 1) * steps)
    assert (early["status"][gone] == Status.DIVERGED).all()


def test_certificates_are_forgotten_and_rests_are_not(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, (LENGTHS[0], LENGTHS[1] % 3000))
    segment = sweep.clock.segment_steps
    evidence = {v.name: v.empty(4, sweep.extents) for v in sweep.measures.evidence}
    evidence["status"][:], evidence["steps"][:] = Status.TIME_OVER, sweep.clock.steps
    evidence["growth"][:], evidence["growth_total"][:] = 0.0, 0.0
    evidence["certificate"][:] = [Certificate.SINK, Certificate.SINK, Certificate.CYCLE, Certificate.REST]
    evidence["certified_steps"][:3] = 12 * segment
    evidence["settled_steps"][:3] = 11 * segment
    evidence["rest_steps"][:] = np.array([0, 6, 0, 8]) * segment
    evidence["equilibrium"][:], evidence["eigenvalue_re"][:], evidence["eigenvalue_im"][:] = 1.0, 2.0, 0.0
    evidence["period"][2], evidence["cycle_hits"][2], evidence["multiplier_re"][2] = 20.0, 2, 0.5
    at = {n: truncated(sweep, evidence, n * segment) for n in (7, 10, 12)}
    kinds = {n: [Certificate(c).name for c in cut["certificate"]] for n, cut in at.items()}
    assert kinds == {
        7: ["NONE", "REST", "NONE", "NONE"],
        10: ["NONE", "REST", "NONE", "REST"],
        12: ["SINK", "SINK", "CYCLE", "REST"],
    }
    assert at[7]["rest_steps"].tolist() == [0, 6 * segment, 0, 0]
    assert np.isnan(at[7]["equilibrium"][[0, 2, 3]]).all()
    assert (at[7]["equilibrium"][1] == 1.0).all()
    assert np.isnan(at[10]["period"][2])
    assert at[10]["cycle_hits"][2] == 0
    assert at[12]["period"][2] == 20.0
    assert classify(sweep, at[10])["region"][[1, 3]].tolist() == [Region.SADDLE] * 2


ENSEMBLE = "ensemble: {num: 40, seed: 1, box: {x: [-20, 20], y: [-20, 20], z: [5, 45]}}"
BASIN = "x: {start: -20, stop: 20, num: 6}\n  y: {start: -20, stop: 21, num: 7}"


@pytest.mark.parametrize("starts", [ENSEMBLE, BASIN])
@pytest.mark.parametrize("stop_early", ["true", "false"])
def test_starts_at_a_horizon_are_those_of_a_run_of_that_length(starts: str, stop_early: str, tmp_path: Path) -> None:
    initial = "initial: {z: 20}" if starts is BASIN else ""

    def opened(duration: int, horizon: float | None = None) -> Result:
        text = (
            f"name: starts\nmodel: lorenz\n{initial}\naxes:\n  rho: {{values: [20, 22, 23, 28]}}\n  {starts}\n"
            f"integrate: {{method: rk4, dt: 0.01, duration: {duration}, segment: 10}}\nstop_early: {stop_early}\n"
        )
        run_sweep(parse_sweep(text), tmp_path / str(duration))
        return open_result(tmp_path / str(duration), horizon)

    real, seen = opened(150), opened(300, 150.0)
    assert seen.horizon == 150
    assert real.horizon is None
    assert set(seen.variables) == set(real.variables)
    went_on = seen["status"] == Status.TIME_OVER
    chaos = real["region"] == Region.CHAOS
    assert chaos.any()
    np.testing.assert_array_equal(seen["region"], np.where(chaos, Region.UNDECIDED, real["region"]))
    assert np.isnan(seen["final_state"][went_on]).all()
    np.testing.assert_array_equal(seen["final_state"][~went_on], real["final_state"][~went_on])
    for name in set(real.variables) - {"region", "final_state", "basin_share", "basin_share_se"}:
        np.testing.assert_array_equal(seen[name], real[name], err_msg=name)
    kinds = [list(real["kind"]).index(name) for name in ("chaos", "undecided")]
    others = [i for i in range(len(real["kind"])) if i not in kinds]
    for name in ("basin_share", "basin_share_se"):
        np.testing.assert_array_equal(seen[name][:, others], real[name][:, others])
    np.testing.assert_allclose(seen["basin_share"][:, kinds[1]], real["basin_share"][:, kinds].sum(axis=1))
    assert "late_growth" not in seen
    assert "no tangent vector" in seen.stored.attributes["region"]["comment"]
    make_figure(seen.at(rho=22))


@pytest.mark.parametrize("steps", [0, 1, 50_000, 62_501])
def test_a_run_cannot_end_anywhere(make_sweep: Callable[..., Sweep], steps: int) -> None:
    sweep = make_sweep(YAW, (LENGTHS[0], LENGTHS[1] % 3000))
    evidence = {v.name: v.empty(1, sweep.extents) for v in sweep.measures.evidence}
    with pytest.raises(ConfigError, match="whole segments of 250 beyond the transient, 1000"):
        truncated(sweep, evidence, steps)


def test_a_horizon_leaves_out_what_other_measures_recorded(make_sweep: Callable[..., Sweep], tmp_path: Path) -> None:
    records = "block: 25}, orbit: {every: 50}, samples: {maxima: r, max: 9}, peak: {of: [p]}}"
    sweep = make_sweep(YAW, ("num: 9", "num: 3"), ("num: 5", "num: 2"), ("block: 25}}", records))
    run_sweep(sweep, tmp_path)
    whole = open_result(tmp_path)
    steps = sweep.clock.transient_steps + 4 * sweep.clock.segment_steps
    cut = open_result(tmp_path, steps * sweep.clock.dt)
    assert {"orbit", "samples", "peak"} & set(whole.variables)
    assert not {"orbit", "samples", "peak"} & set(cut.variables)
    expected = classify(sweep.without_records(), truncated(sweep, _integrated(sweep), steps))
    for name in SAME:
        np.testing.assert_array_equal(cut[name].reshape(expected[name].shape), expected[name], err_msg=name)
    assert draw(cut, tmp_path / "map.png").is_file()


def test_a_horizon_is_taken_as_it_is_printed(make_sweep: Callable[..., Sweep]) -> None:
    forced = make_sweep(FORCED)
    clock = forced.clock
    length = clock.segment_steps * clock.dt
    looks = range(clock.transient_segments + 1, clock.segments + 1)
    for look in looks:
        steps = look * clock.segment_steps
        for text in (f"{look * length:.2f}", f"{look * length:.10g}"):
            assert forced.steps_at(float(text)) == steps
    with pytest.raises(ConfigError) as caught:
        forced.steps_at(looks[0] * length + 0.4 * length)
    nearest = re.findall(r"[0-9.]+", str(caught.value).partition("nearest")[2])[:2]
    assert [forced.steps_at(float(text)) // clock.segment_steps for text in nearest] == [looks[0], looks[1]]
    with pytest.raises(ConfigError, match="nothing is stored"):
        forced.steps_at((looks[0] + 2e-4) * length)
