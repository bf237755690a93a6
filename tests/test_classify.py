"""Classification: made-up evidence whose answer is known, and orbits of models whose answer is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from quavsweep.classify import classify, missing_sum, missing_zero, regions, result_variables, unsettled
from quavsweep.codes import Certificate, Region, Status
from quavsweep.config import Sweep, load_sweep
from quavsweep.config.schema import Effort
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.measures import Evidence
from quavsweep.plan import make_plan
from quavsweep.point import compute_point
from tests.conftest import LORENZ, YAW

SEGMENTS = 16
TRANSIENT = 4
CHAOS, CYCLE = (0.04, 0.0, -0.23), (0.0, -0.03, -0.16)


@pytest.fixture
def sweep(make_sweep: Callable[..., Sweep]) -> Sweep:
    sweep = make_sweep(YAW, ("transient: 200, duration: 600", "transient: 1000, duration: 3000"))
    assert (sweep.clock.segments, sweep.clock.transient_segments) == (SEGMENTS, TRANSIENT)
    return sweep


def _evidence(sweep: Sweep, rates: object, noise: object = 0.0, bounded: object = 0.0, seed: int = 0) -> Evidence:
    """Return evidence of cells whose exponents have these rates, (n, K) or in each segment (n, segments, K).

    To the growth in a batch come `noise` [1/time] that adds up, and differences of a quantity of the size `bounded`.
    """
    clock = sweep.clock
    rates = np.asarray(rates, dtype=float)
    if rates.ndim == 2:
        rates = np.repeat(rates[:, None], clock.segments, axis=1)
    evidence = {v.name: v.empty(len(rates), sweep.extents) for v in sweep.measures.evidence}
    batch = clock.batch_steps * clock.dt
    rng = np.random.default_rng(seed)
    growth = batch * np.repeat(rates, clock.segment_batches, axis=1)
    growth += np.asarray(noise) * batch * rng.normal(size=growth.shape)
    n, batches, k = growth.shape
    growth += np.diff(np.asarray(bounded) * rng.uniform(-1, 1, size=(n, batches + 1, k)), axis=1)
    evidence["growth"][:] = growth
    evidence["growth_total"][:] = growth.cumsum(axis=1)[:, clock.segment_batches - 1 :: clock.segment_batches]
    evidence["status"][:] = Status.TIME_OVER
    evidence["steps"][:] = clock.steps
    evidence["state"][:] = 0.0
    return evidence


def _certify(sweep: Sweep, evidence: Evidence, kind: Certificate, segments: object) -> None:
    """Let cells be certified after so many segments."""
    steps = sweep.clock.segment_steps
    evidence["certificate"][:] = kind
    evidence["certified_steps"][:] = np.asarray(segments) * steps
    evidence["settled_steps"][:] = evidence["certified_steps"] - steps
    if kind == Certificate.SINK:
        evidence["eigenvalue_re"][:] = [-0.016, -0.016, -0.158]
    else:
        evidence["period"][:] = 20.0
        evidence["multiplier_re"][:] = np.exp(20.0 * np.array([1e-12, -0.04, -0.15]))
        evidence["multiplier_im"][:] = 0.0


def _region(sweep: Sweep, evidence: Evidence) -> list[Region]:
    return [Region(value) for value in classify(sweep, evidence)["region"]]


def test_signs_of_the_exponents(sweep: Sweep) -> None:
    rates = [CHAOS, CYCLE, (0.0, 0.0, -0.19), (-0.02, -0.02, -0.15), (0.0, 0.0, 0.0)]
    found = _region(sweep, _evidence(sweep, rates))
    expected = [Region.CHAOS, Region.PERIODIC, Region.QUASI_PERIODIC, Region.UNDECIDED]
    assert found[:4] == expected
    assert Region.CHAOS not in found[4:]


def test_noise_hides_a_small_exponent_but_does_not_make_it_neutral(sweep: Sweep) -> None:
    rates = [CHAOS] * 400
    quiet = _region(sweep, _evidence(sweep, rates, noise=0.002, bounded=1.0))
    loud = _region(sweep, _evidence(sweep, rates, noise=[0.3, 0.0, 0.3], bounded=1.0))
    assert set(quiet) == {Region.CHAOS}
    assert set(loud) <= {Region.UNDECIDED, Region.CHAOS}
    assert loud.count(Region.CHAOS) < 20


def test_bounded_growth_in_the_direction_of_the_flow_is_neutral(sweep: Sweep) -> None:
    for size in (1e-3, 0.1, 1.0):
        found = _region(sweep, _evidence(sweep, [CYCLE] * 1000, bounded=[size, size, size]))
        assert Region.CHAOS not in found
        assert found.count(Region.PERIODIC) > 900


def test_an_orbit_that_leaves_a_weak_saddle_is_not_chaotic(sweep: Sweep) -> None:
    assert _region(sweep, _evidence(sweep, [(0.002, -0.04, -0.15)])) == [Region.UNDECIDED]


def test_chaos_that_has_ended_is_not_chaos(sweep: Sweep) -> None:
    rates = np.tile(CHAOS, (200, SEGMENTS, 1))
    rates[:100, -3:] = CYCLE
    rates[100:, -3:] = (-0.016, -0.016, -0.158)
    result = classify(sweep, _evidence(sweep, rates, noise=[0.01, 0, 0.01], bounded=0.5))
    assert not (result["region"] == Region.CHAOS).any()
    assert result["was_chaotic"].all()
    length = sweep.clock.segment_steps * sweep.clock.dt
    assert np.median(np.abs(result["chaotic_until"] / length - (SEGMENTS - 3))) <= 0.25
    assert np.quantile(np.abs(result["chaotic_until"] / length - (SEGMENTS - 3)), 0.9) <= 0.5
    off = np.abs(result["lyapunov_chaotic"] - 0.04) / result["lyapunov_chaotic_se"]
    assert np.median(off) < 1
    assert np.quantile(off, 0.9) < 3


def test_while_chaotic_is_always_for_lasting_chaos(sweep: Sweep) -> None:
    result = classify(sweep, _evidence(sweep, [CHAOS, CYCLE], bounded=[[[0.5, 0.5, 0.5]]]))
    assert result["lyapunov_chaotic"][0] == result["lyapunov"][0, 0]
    assert result["lyapunov_chaotic_se"][0] == result["lyapunov_se"][0, 0]
    assert result["chaotic_until"][0] == result["time_used"][0]
    for name in ("chaotic_until", "lyapunov_chaotic", "lyapunov_chaotic_se"):
        assert np.isnan(result[name][1])


def test_a_sink_has_exact_exponents_and_keeps_the_raw_ones(sweep: Sweep) -> None:
    evidence = _evidence(sweep, [(-0.015, 0.0, -0.175)] * 3)
    _certify(sweep, evidence, Certificate.SINK, [10, 3, 4])
    evidence["status"][:] = Status.ENDED_SINK
    evidence["steps"][:] = evidence["certified_steps"]
    result = classify(sweep, evidence)
    assert list(result["region"]) == [Region.SINK] * 3
    np.testing.assert_array_equal(result["lyapunov"], evidence["eigenvalue_re"])
    assert (result["lyapunov_se"] == 0).all()
    np.testing.assert_allclose(result["lyapunov_raw"][0], [-0.015, 0.0, -0.175], atol=1e-9)
    assert np.isnan(result["lyapunov_raw"][1:]).all()  # ended within the transient
    np.testing.assert_allclose(result["settle_time"], [2250, 500, 750])
    np.testing.assert_allclose(result["time_used"], [2500, 750, 1000])
    assert list(result["was_chaotic"]) == [0, 0, 0]
    assert np.isnan(result["zero_error"]).all()


def test_a_cycle_has_the_exponents_of_its_multipliers(sweep: Sweep) -> None:
    evidence = _evidence(sweep, [(0.001, -0.03, -0.16)] * 2)
    _certify(sweep, evidence, Certificate.CYCLE, [10, 3])
    evidence["multiplier_re"][1, 1:], evidence["multiplier_im"][1, 1:] = -0.3, [0.4, -0.4]
    evidence["status"][:] = [Status.TIME_OVER, Status.ENDED_CYCLE]
    result = classify(sweep, evidence)
    assert list(result["region"]) == [Region.PERIODIC] * 2
    np.testing.assert_allclose(result["lyapunov"][0], [1e-12, -0.04, -0.15], atol=1e-15)
    np.testing.assert_allclose(result["lyapunov"][1, 1:], [np.log(0.5) / 20] * 2)
    assert (result["lyapunov_se"] == 0).all()
    np.testing.assert_allclose(result["zero_error"], 1e-12, atol=1e-15)
    np.testing.assert_allclose(result["settle_time"], [2250, 500])
    np.testing.assert_array_equal(result["period"], 20.0)


def test_a_sink_reached_through_chaos_was_chaotic(sweep: Sweep) -> None:
    rates = np.tile((-0.016, -0.016, -0.158), (3, SEGMENTS, 1))
    rates[0, :8] = (0.05, 0.0, -0.24)
    rates[1, 0] = (0.05, 0.0, -0.24)  # one growth at the start is no chaos
    rates[2, 10:] = (0.05, 0.0, -0.24)  # nor is what comes after the certificate
    evidence = _evidence(sweep, rates)
    _certify(sweep, evidence, Certificate.SINK, 10)
    result = classify(sweep, evidence)
    assert list(result["was_chaotic"]) == [1, 0, 0]
    assert result["chaotic_until"][0] == 2000
    assert result["lyapunov_chaotic"][0] == pytest.approx(0.05)


def test_averages_of_regular_orbits_do_not_mix_in_their_chaos(sweep: Sweep) -> None:
    rates = np.tile(CYCLE, (50, SEGMENTS, 1))
    rates[:25, 1:6] = (0.3, 0.0, -0.49)
    evidence = _evidence(sweep, rates, bounded=[0.5, 0.5, 0.5])
    result = classify(sweep, evidence)
    assert list(result["region"]) == [Region.PERIODIC] * 50
    assert list(result["was_chaotic"]) == [1] * 25 + [0] * 25
    assert np.abs(result["chaotic_until"][:25] / (sweep.clock.segment_steps * sweep.clock.dt) - 6).max() <= 0.25
    np.testing.assert_allclose(result["lyapunov"], [CYCLE] * 50, atol=2e-3)
    assert (result["lyapunov_raw"][:25, 0] > 0.03).all()
    np.testing.assert_array_equal(result["lyapunov_raw"][25:], result["lyapunov"][25:])
    assert (np.abs(result["lyapunov"] - CYCLE) < 5 * result["lyapunov_se"] + 1e-3).all()
    assert (result["growth_departure"][:, 0] < 2).all()
    assert (result["zero_error"] < 2e-3).all()


@pytest.mark.parametrize(("rate", "was"), [(0.25, 1), (0.1, 0)])
def test_chaos_too_short_for_an_error_is_told_by_its_growth(sweep: Sweep, rate: float, was: int) -> None:
    """What leaves a saddle grows by ln of its distance, at most 36: 62.5 is chaos, 25 may be none."""
    rates = np.tile(CYCLE, (2, SEGMENTS, 1))
    rates[:, 1] = (rate, 0.0, -0.19 - rate)
    evidence = _evidence(sweep, rates)
    _certify(sweep, evidence, Certificate.CYCLE, 10)
    evidence["certificate"][1] = Certificate.NONE
    result = classify(sweep, evidence)
    assert list(result["region"]) == [Region.PERIODIC] * 2
    assert list(result["was_chaotic"]) == [was] * 2
    if was:
        np.testing.assert_array_equal(result["chaotic_until"], 500)
        np.testing.assert_allclose(result["lyapunov_chaotic"], rate)
        assert np.isinf(result["lyapunov_chaotic_se"]).all()


def test_what_was_chaotic_does_not_depend_on_stopping_early(sweep: Sweep) -> None:
    rates = np.tile((-0.016, -0.016, -0.158), (100, SEGMENTS, 1))
    rates[:, :8] = (0.05, 0.0, -0.24)
    evidence = _evidence(sweep, rates, noise=[0.02, 0, 0.02], bounded=0.5)
    _certify(sweep, evidence, Certificate.SINK, 10)
    long = classify(sweep, evidence)
    evidence["steps"][:] = evidence["certified_steps"]
    evidence["growth"][:, 40:], evidence["growth_total"][:, 10:] = np.nan, np.nan
    evidence["status"][:] = Status.ENDED_SINK
    short = classify(sweep, evidence)
    for name in ("region", "was_chaotic", "chaotic_until", "lyapunov_chaotic", "lyapunov_chaotic_se", "lyapunov"):
        np.testing.assert_array_equal(short[name], long[name])
    assert np.median(np.abs(long["chaotic_until"] - 2000)) <= 62.5


def test_an_orbit_that_rests_on_a_saddle_was_not_chaotic(sweep: Sweep) -> None:
    evidence = _evidence(sweep, [(2.7, -0.05, -2.9)])
    evidence["certificate"][:] = Certificate.REST
    evidence["eigenvalue_re"][:] = [2.7, -0.05, -2.9]
    result = classify(sweep, evidence)
    assert result["region"][0] == Region.SADDLE
    assert result["was_chaotic"][0] == 0


def test_statuses_that_decide_by_themselves(sweep: Sweep) -> None:
    evidence = _evidence(sweep, np.zeros((5, 3)))
    evidence["status"][:] = [
        Status.NOT_COMPUTED,
        Status.FAILED,
        Status.DIVERGED,
        Status.FRAME_DEGENERATE,
        Status.TIME_OVER,
    ]
    evidence["growth_total"][:4] = np.nan
    evidence["certificate"][4] = Certificate.REST
    evidence["eigenvalue_re"][4] = [2.7, -0.05, -2.9]
    result = classify(sweep, evidence)
    expected = [Region.NONE, Region.NONE, Region.UNBOUNDED, Region.UNDECIDED, Region.SADDLE]
    assert [Region(value) for value in result["region"]] == expected
    assert np.isnan(result["lyapunov"][:4]).all()
    np.testing.assert_array_equal(regions(sweep, evidence), result["region"])
    assert not unsettled(sweep, evidence).any()
    going = replace(sweep, config=sweep.config.model_copy(update={"effort": Effort(max_duration=1e5)}))
    assert unsettled(going, evidence).tolist() == [False, False, False, True, False]


def test_raw_sums_are_compared_with_the_mean_divergence(sweep: Sweep) -> None:
    evidence = _evidence(sweep, [CHAOS, CYCLE, CHAOS], noise=[0.01, 0, 0.01])
    total = evidence["growth_total"].sum(axis=2)
    evidence["divergence"][:2] = total[:2] - 1e-6 * sweep.clock.dt * sweep.clock.segment_steps * np.arange(1, 17)
    error = classify(sweep, evidence)["sum_error"]
    np.testing.assert_allclose(error[:2], 1e-6, rtol=1e-6)
    assert np.isnan(error[2])  # not available is not 0


def test_self_checks_say_why_they_are_not_available(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW)
    assert missing_sum(sweep) == missing_zero(sweep) == ""
    traced = make_sweep(YAW, ("block: 25", "block: 25, last_from_trace: true"))
    assert missing_sum(traced) == "the last exponent is made of the sum"
    assert "last exponent is made" in {v.name: v for v in result_variables(traced)}["sum_error"].meaning
    assert missing_sum(make_sweep(YAW, ("exponents: 3", "exponents: 2"))) == "2 of 3 exponents are measured"


def test_the_zero_error_is_that_of_the_neutral_exponent(sweep: Sweep) -> None:
    result = classify(sweep, _evidence(sweep, [(0.04, 1e-5, -0.23), (0.0, -0.03, -0.16), (-0.02, -0.02, -0.15)]))
    np.testing.assert_allclose(result["zero_error"][:2], [1e-5, 0], rtol=1e-3)
    assert np.isnan(result["zero_error"][2])


def test_no_exponent_along_the_flow_departs_from_its_line_by_more_than_a_speed_can(sweep: Sweep) -> None:
    rates = np.tile((0.0, -0.3, -0.4), (2, SEGMENTS, 1))
    rates[:, 4:6, 0] = [[0.05], [0.15]]  # 25 and 75 of ln, perhaps along a saddle, but no speed
    result = classify(sweep, _evidence(sweep, rates, noise=[1e-3, 0, 0]))
    assert (result["growth_departure"][:, 0] > [15, 36]).all()
    assert not np.isfinite(result["zero_error"][1])


def test_every_cell_has_every_variable(sweep: Sweep) -> None:
    result = classify(sweep, _evidence(sweep, np.zeros((3, 3))))
    for variable in result_variables(sweep):
        assert result[variable.name].shape == variable.shape(3, sweep.extents)
        assert result[variable.name].dtype == variable.dtype


def test_the_rules_do_not_depend_on_company(sweep: Sweep) -> None:
    rng = np.random.default_rng(3)
    evidence = _evidence(sweep, rng.normal(scale=0.03, size=(50, SEGMENTS, 3)), noise=0.02)
    whole = classify(sweep, evidence)
    for start, stop in ((0, 1), (7, 30), (49, 50)):
        part = classify(sweep, {name: values[start:stop] for name, values in evidence.items()})
        for name, values in part.items():
            np.testing.assert_array_equal(values, whole[name][start:stop], err_msg=name)


def test_more_batches_than_were_used_change_nothing(make_sweep: Callable[..., Sweep], sweep: Sweep) -> None:
    evidence = _evidence(sweep, np.repeat([CHAOS, CYCLE], 20, axis=0), noise=[0.02, 0, 0.02], bounded=0.5)
    longer = dict(evidence)
    for name in ("growth", "growth_total", "divergence"):
        values = evidence[name]
        longer[name] = np.concatenate([values, np.full_like(values, np.nan)], axis=1)
    expected = classify(sweep, evidence)
    for name, values in classify(sweep, longer).items():
        np.testing.assert_array_equal(values, expected[name], err_msg=name)


VERDICT = ("measures: {lyapunov: {exponents: 3, block: 25}}", "measures: {verdict: {batches: 32}}")


def test_a_verdict_tells_chaos_and_nothing_else(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, VERDICT)
    evidence = {v.name: v.empty(4, sweep.extents) for v in sweep.measures.evidence}
    evidence["status"][:], evidence["steps"][:] = Status.TIME_OVER, sweep.clock.steps
    rng = np.random.default_rng(0)
    evidence["late_growth"][0] = 1.0 + rng.normal(size=32)
    evidence["late_growth"][1] = np.diff(rng.uniform(-1, 1, size=33))
    evidence["late_growth"][2] = np.where(np.arange(32) < 16, 1.0, -0.2)
    assert regions(sweep, evidence).tolist() == [Region.CHAOS, *[Region.UNDECIDED] * 3]
    evidence["certificate"][:] = Certificate.CYCLE
    assert regions(sweep, evidence).tolist() == [Region.PERIODIC] * 4
    assert "lyapunov" not in classify(sweep, evidence)


def test_without_exponents_what_is_not_certified_is_undecided(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("measures: {lyapunov: {exponents: 3, block: 25}}", "measures: {}"))
    evidence = {v.name: v.empty(1, sweep.extents) for v in sweep.measures.evidence}
    evidence["status"][:] = Status.TIME_OVER
    assert regions(sweep, evidence).tolist() == [Region.UNDECIDED]


def _integrated(sweep: Sweep) -> Evidence:
    return integrate_tile(make_plan(sweep, 16), Tile(0, 0, sweep.grid.size), lambda: False)


def _uncertified(evidence: Evidence) -> Evidence:
    """Return evidence without certificates: what the classification sees if none was found."""
    evidence["certificate"][:] = Certificate.NONE
    evidence["status"][:] = Status.TIME_OVER
    return evidence


def test_cycles_without_a_certificate_are_never_chaotic(make_sweep: Callable[..., Sweep]) -> None:
    """Stable cycles of the Lorenz system beyond rho = 220, where there is no chaos but near their bifurcations."""
    sweep = make_sweep(
        LORENZ + "stop_early: false\n",
        ("start: 0.5, stop: 600, num: 60", "start: 330, stop: 400, num: 100"),
        ("dt: 0.02", "dt: 0.004"),
        ("block: 5", "block: 20"),
        ("transient: 20, duration: 80", "transient: 100, duration: 400"),
    )
    result = classify(sweep, _uncertified(_integrated(sweep)))
    assert not (result["region"] == Region.CHAOS).any()
    assert not (result["region"] == Region.QUASI_PERIODIC).any()
    assert (result["region"] == Region.PERIODIC).mean() > 0.9


def test_chaos_of_the_lorenz_system_is_never_periodic(make_sweep: Callable[..., Sweep]) -> None:
    for duration in (40, 400):  # also where it is too short to tell
        sweep = make_sweep(
            LORENZ + "stop_early: false\n",
            ("start: 0.5, stop: 600, num: 60", "start: 28, stop: 50, num: 100"),
            ("dt: 0.02", "dt: 0.005"),
            ("block: 5", "block: 20"),
            ("transient: 20, duration: 80", f"transient: 50, duration: {duration}"),
        )
        found = classify(sweep, _uncertified(_integrated(sweep)))["region"]
        assert set(found.tolist()) <= {Region.CHAOS, Region.UNDECIDED}
        assert (found == Region.CHAOS).mean() > (0.99 if duration == 400 else 0.5)


@pytest.mark.slow
def test_certified_ends_agree_with_the_long_averages(make_sweep: Callable[..., Sweep]) -> None:
    """Every certified cell of a thumbnail of the plane, integrated to the end: without certificates none is chaotic."""
    sweep = make_sweep(
        YAW + "stop_early: false\n",
        ("num: 9", "num: 46"),
        ("num: 5", "num: 21"),
        ("transient: 200, duration: 600", "transient: 1000, duration: 3000"),
    )
    evidence = _integrated(sweep)
    exact = classify(sweep, evidence)
    cycle = evidence["certificate"] == Certificate.CYCLE
    blind = classify(sweep, _uncertified(evidence))
    found = blind["region"][cycle]
    regular = cycle & (blind["was_chaotic"] == 0)
    off = np.abs(blind["lyapunov"] - exact["lyapunov"])[regular]
    departure = 2 * blind["growth_departure"] / sweep.clock.duration
    within = off <= np.maximum(3 * blind["lyapunov_se"], departure)[regular]
    periodic = (found == Region.PERIODIC).mean()
    print(
        f"\n{cycle.sum()} cycles, {periodic:.1%} periodic without certificates; averages right in {within.mean(axis=0)}"
    )
    assert not np.isin(found, (Region.CHAOS, Region.QUASI_PERIODIC)).any()
    assert (np.abs(exact["zero_error"][cycle]) < 1e-8).all()
    assert (within.mean(axis=0) > 0.97).all()


def test_an_orbit_that_comes_to_a_cycle_slowly_is_no_torus() -> None:
    """It has two neutral exponents and is regular; at 8,000 s its cycle is certified."""
    sweep = load_sweep(Path(__file__).parent.parent / "configs" / "omega_c.yaml")
    point = compute_point(sweep, {"Omega1": 332, "c": 4.74})
    assert point.values["birkhoff_digits"] > sweep.config.classify.digits
    assert point.values["region"] == Region.UNDECIDED
