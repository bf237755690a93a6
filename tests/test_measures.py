"""Dense measures: against closed forms of a linear oscillator, and nothing that depends on company."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quavsweep.codes import Certificate, Status
from quavsweep.config import Sweep, dump_config, parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.measures import Evidence
from quavsweep.models import Model, Parameter, State
from quavsweep.plan import make_plan
from quavsweep.result import open_result
from quavsweep.sweep import run_sweep
from tests.conftest import LORENZ, YAW


def _rhs(x, v, k):  # type: ignore[no-untyped-def]
    return v, -k * x


OSCILLATOR = Model("oscillator", _rhs, (State("x"), State("v")), (Parameter("k", 1.0),))

# x = cos(w t), v = -w sin(w t) with w = 1, 2, 3.
SPRING = """
name: spring
model: lorenz
initial: {x: 1.0, y: 0.0, z: 0.0}
axes: {rho: {values: [1.0, 4.0, 9.0]}}
integrate: {dt: 0.01, transient: 2, duration: 8}
measures: {MEASURES}
"""


def _oscillator(measures: str, monkeypatch: pytest.MonkeyPatch) -> Sweep:
    monkeypatch.setattr("quavsweep.config.load.load_model", lambda name: OSCILLATOR)
    text = SPRING.replace("y: 0.0, z: 0.0", "v: 0.0").replace("rho", "k").replace("MEASURES", measures)
    return parse_sweep(text)


def _evidence(sweep: Sweep, start: int = 0, stop: int | None = None, lanes: int = 16) -> Evidence:
    tile = Tile(0, start, sweep.grid.size if stop is None else stop)
    return integrate_tile(make_plan(sweep, lanes), tile, lambda: False)


def test_an_orbit_is_stored_at_even_times(monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = _oscillator("orbit: {every: 0.05}", monkeypatch)
    times = sweep.dimensions["time"].values
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(10.0)
    assert len(times) == 201
    for w, orbit in zip((1.0, 2.0, 3.0), _evidence(sweep)["orbit"], strict=True):
        np.testing.assert_allclose(orbit[:, 0], np.cos(w * times), atol=1e-6)
        np.testing.assert_allclose(orbit[:, 1], -w * np.sin(w * times), atol=1e-6)


def test_an_orbit_has_a_window(monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = _oscillator("orbit: {every: 0.3, after: 1, until: 3}", monkeypatch)
    whole = _evidence(_oscillator("orbit: {every: 0.1}", monkeypatch))["orbit"]
    np.testing.assert_allclose(sweep.dimensions["time"].values, np.arange(1, 3.01, 0.3))
    np.testing.assert_array_equal(_evidence(sweep)["orbit"], whole[:, 10:31:3])


@pytest.mark.parametrize(
    ("measures", "phase", "spacing"),
    [
        ("samples: {maxima: x, max: 5}", 0.0, 1.0),
        ("samples: {max: 5}", 0.0, 1.0),
        ("samples: {section: {of: x}, max: 5}", 0.75, 1.0),
        ("samples: {section: {of: x, direction: down}, max: 5}", 0.25, 1.0),
        ("samples: {section: {of: x, direction: both}, max: 5}", 0.25, 0.5),
    ],
)
def test_samples_lie_on_the_section(
    measures: str, phase: float, spacing: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    evidence = _evidence(_oscillator(measures, monkeypatch))
    for i, w in enumerate((1.0, 2.0, 3.0)):
        expected = (phase + spacing * np.arange(100)) * 2 * np.pi / w
        expected = expected[(expected > 2) & (expected < 10)]
        assert evidence["sample_count"][i] == len(expected)
        kept = min(5, len(expected))
        np.testing.assert_allclose(evidence["sample_time"][i, :kept], expected[:kept], atol=1e-6)
        np.testing.assert_allclose(evidence["samples"][i, :kept, 0], np.cos(w * expected[:kept]), atol=1e-6)
        assert np.isnan(evidence["samples"][i, kept:]).all()


def test_samples_at_even_times(monkeypatch: pytest.MonkeyPatch) -> None:
    evidence = _evidence(_oscillator("samples: {every: 0.5, max: 4}", monkeypatch))
    assert list(evidence["sample_count"]) == [17, 17, 17]
    np.testing.assert_allclose(evidence["sample_time"][0], [2, 2.5, 3, 3.5])
    np.testing.assert_allclose(evidence["samples"][1, :, 0], np.cos([4, 5, 6, 7]), atol=1e-6)


def test_peaks_and_first_times(monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = _oscillator("peak: {of: [v, x], until: 1}, first_time: {of: x, below: -0.5, until: 2}", monkeypatch)
    evidence = _evidence(sweep)
    w = np.array([1.0, 2.0, 3.0])
    quarter = np.minimum(np.pi / 2 / w, 1.0)
    np.testing.assert_allclose(evidence["peak"][:, 0], -w * np.sin(w * quarter), atol=1e-6)
    np.testing.assert_allclose(evidence["peak_time"][:, 0], quarter, atol=1e-5)
    assert (evidence["peak"][:, 1] == 1).all()
    assert (evidence["peak_time"][:2, 1] == 0).all()
    expected = np.arccos(-0.5) / w
    np.testing.assert_allclose(evidence["first_time"], np.where(expected < 2, expected, np.nan), atol=1e-6)
    assert np.isnan(evidence["first_time"][0])


def test_an_orbit_that_begins_beyond_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    evidence = _evidence(_oscillator("first_time: {of: x, above: 0.5}", monkeypatch))
    assert (evidence["first_time"] == 0).all()


def test_an_orbit_that_begins_at_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    at_once = _oscillator("first_time: {of: x, below: 1.0}", monkeypatch)
    assert (np.abs(_evidence(at_once)["first_time"]) < 1e-6).all()
    leaves = _oscillator("first_time: {of: v, below: 0.0}", monkeypatch)
    assert (np.abs(_evidence(leaves)["first_time"]) < 1e-6).all()


def test_a_frame_that_loses_rank_does_not_end_what_looks_at_states(make_sweep: Callable[..., Sweep]) -> None:
    one = ("start: 0.5, stop: 600, num: 60", "values: [28]")
    peak = ", peak: {of: [z], until: 90}, orbit: {every: 2, until: 90}"
    good = _evidence(make_sweep(LORENZ, one, ("block: 5}", "block: 50}" + peak)))
    lost = _evidence(make_sweep(LORENZ, one, ("block: 5}", "block: 200}" + peak)))
    assert lost["status"][0] == Status.FRAME_DEGENERATE
    assert lost["peak"].tolist() == good["peak"].tolist()
    np.testing.assert_array_equal(lost["orbit"], good["orbit"])
    assert np.isnan(lost["growth"]).all()


def test_a_cell_that_diverges_has_no_peak(make_sweep: Callable[..., Sweep]) -> None:
    values = ("start: 0.5, stop: 600, num: 60", "values: [28, 2000]")
    evidence = _evidence(make_sweep(LORENZ, values, ("block: 5}", "block: 5}, peak: {of: [z], until: 50}")))
    assert evidence["status"][1] == Status.DIVERGED
    assert np.isfinite(evidence["peak"][0]).all()
    assert np.isnan(evidence["peak"][1]).all()


@pytest.mark.parametrize("until", [1e-3, 0.02, 0.5, 700])
def test_a_window_is_never_empty(make_sweep: Callable[..., Sweep], until: float) -> None:
    measures = f"orbit: {{every: 0.02, until: {until}}}, peak: {{of: [p], until: {until}}}"
    canonical = make_sweep(YAW, ("block: 25}", "block: 25}, " + measures)).canonical()
    assert parse_sweep(dump_config(canonical)).canonical() == canonical


ALL = (
    "orbit: {every: 0.4, until: 60}, samples: {section: {of: z, at: 27}, max: 20}, "
    "peak: {of: [x, z], until: 50}, first_time: {of: z, above: 30, until: 40}"
)


def test_dense_measures_do_not_change_a_bit_of_the_others(make_sweep: Callable[..., Sweep]) -> None:
    change = ("block: 5}", "block: 5}, samples: {maxima: z, max: 7}")
    plain, dense = _evidence(make_sweep(LORENZ)), _evidence(make_sweep(LORENZ, change))
    for name, values in plain.items():
        assert values.tobytes() == dense[name].tobytes(), name


def test_dense_measures_do_not_depend_on_tile_or_lanes(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(LORENZ, ("block: 5}", f"block: 5}}, {ALL}"))
    whole = _evidence(sweep)
    assert {Status.TIME_OVER, Status.ENDED_SINK, Status.DIVERGED} <= {Status(s) for s in whole["status"]}
    for start, stop, lanes in ((0, 1, 16), (3, 40, 32), (17, 60, 24)):
        part = _evidence(sweep, start, stop, lanes)
        for name, values in part.items():
            assert values.tobytes() == whole[name][start:stop].tobytes(), name


def test_a_cell_does_not_end_while_a_measure_looks_at_it(make_sweep: Callable[..., Sweep]) -> None:
    plain = _evidence(make_sweep(LORENZ))
    sweep = make_sweep(LORENZ, ("block: 5}", "block: 5}, peak: {of: [x], until: 60}"))
    evidence = _evidence(sweep)
    sink = evidence["certificate"] == Certificate.SINK
    assert (plain["steps"][sink] * 0.02 < 60).any()
    assert (evidence["steps"][sink] * 0.02 >= 60).all()
    assert (evidence["status"][sink] == Status.ENDED_SINK).all()
    np.testing.assert_array_equal(plain["certified_steps"], evidence["certified_steps"])


def test_an_orbit_is_that_of_an_independent_integrator(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    axes = "axes:\n  Omega1: {start: 50, stop: 500, num: 9}\n  c: {start: 3, stop: 7, num: 5}\n"
    sweep = make_sweep(
        YAW,
        (axes, ""),
        ("dt: 0.02", "dt: 0.005"),
        ("lyapunov: {exponents: 3, block: 25}", "orbit: {every: 0.5, until: 60}"),
    )
    result = open_result(run_sweep(sweep, tmp_path))
    assert result["orbit"].shape == (121, 3)
    rhs, p = sweep.model.rhs, sweep.parameters
    solution = solve_ivp(
        lambda t, u: rhs(*u, **p), (0, 60), [1e-3] * 3, t_eval=result["time"], method="DOP853", rtol=1e-12, atol=1e-14
    )
    np.testing.assert_allclose(result["orbit"], solution.y.T, atol=1e-6)


def test_results_of_dense_measures_open_in_xarray(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    xarray = pytest.importorskip("xarray")
    path = run_sweep(make_sweep(LORENZ, ("block: 5}", f"block: 5}}, {ALL}")), tmp_path)
    with xarray.open_dataset(path) as data:
        assert data.orbit.dims == ("rho", "time", "state")
        assert data.samples.dims == ("rho", "sample", "state")
        assert data.peak.dims == ("rho", "peak_of")
        assert list(data.peak_of.values) == ["x", "z"]
        assert data.sample_count.dtype == np.int32
        assert data.first_time.attrs["units"] == "1"


@pytest.mark.parametrize(
    ("measures", "says"),
    [
        ("orbit: {every: 0}", r"measures.orbit.every"),
        ("orbit: {every: 1000}", r"measures.orbit.every: 1000 lies behind the end of the run; at most .* 800"),
        ("orbit: {every: 1, until: 900}", r"measures.orbit.until: 900 lies behind the end"),
        ("orbit: {every: 1, after: 30, until: 20}", r"measures.orbit.after: 30 lies behind the last time"),
        ("orbit: {every: 1e-9}", r"measures.orbit.every: 1e-09 gives more than 10000000 states"),
        (
            "samples: {maxima: w}",
            r"measures.samples.maxima: quadrotor_yaw has no state or observable w; it has p, q, r; of these .*",
        ),
        ("samples: {section: {of: w}}", r"measures.samples.section.of: quadrotor_yaw has no state or observable w"),
        ("samples: {section: {of: p}, maxima: p}", r"section and maxima exclude each other"),
        ("samples: {max: 0}", r"measures.samples.max: 0"),
        ("peak: {of: []}", r"measures.peak.of"),
        ("peak: {of: [p, p]}", r"measures.peak.of: a quantity is given twice"),
        ("peak: {of: [casimir_powr]}", r"peak.of: .* observable casimir_powr, did you mean casimir_power\?; it has"),
        ("statistics: {of: []}", r"measures.statistics.of"),
        ("statistics: {of: [Ix]}", r"measures.statistics.of: quadrotor_yaw has no state or observable Ix"),
        ("statistics: {of: [p], after: 1e9}", r"measures.statistics.after: 1e\+09 lies behind the end of the run"),
        ("first_time: {of: p}", r"measures.first_time: give either above or below"),
        ("first_time: {of: z, above: 1}", r"measures.first_time.of: quadrotor_yaw has no state or observable z"),
    ],
)
def test_what_is_wrong_with_a_measure_is_named(make_sweep: Callable[..., Sweep], measures: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        make_sweep(YAW, ("lyapunov: {exponents: 3, block: 25}", measures))


def test_times_of_measures_are_whole_steps_and_said(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("block: 25}", "block: 25}, orbit: {every: 0.05, until: 20}"))
    assert sweep.warnings == ("measures.orbit.every is rounded to whole steps: 0.05 -> 0.04",)
    canonical = sweep.canonical()
    assert canonical["measures"]["orbit"] == {"every": 0.04, "after": 0.0, "until": 20.0}
    again = parse_sweep(dump_config(canonical))
    assert again.canonical() == canonical
    assert dataclasses.replace(again, config=sweep.config, warnings=sweep.warnings) == sweep


@pytest.mark.parametrize("at", [0.0, 0.5])
def test_the_last_time_at_a_value_is_that_of_the_last_crossing(at: float, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = _oscillator(f"last_time: {{of: x, at: {at}}}", monkeypatch)
    turns = np.arange(-1, 20)
    for w, found in zip((1.0, 2.0, 3.0), _evidence(sweep)["last_time"], strict=True):
        phases = np.concatenate([2 * np.pi * turns + np.arccos(at), 2 * np.pi * turns - np.arccos(at)])
        assert found == pytest.approx(max(phase / w for phase in phases if phase / w <= 10), abs=1e-6)


def test_there_is_no_last_time_at_a_value_that_is_never_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    assert np.isnan(_evidence(_oscillator("last_time: {of: x, at: 1.5}", monkeypatch))["last_time"]).all()
