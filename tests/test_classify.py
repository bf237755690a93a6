"""Classification: made-up evidence whose answer is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from quavsweep.classify import Sums, classify, result_variables
from quavsweep.codes import Certificate, Region, Status
from quavsweep.config import Sweep
from quavsweep.measures import Evidence
from tests.conftest import LORENZ, YAW

SEGMENTS = 16
TRANSIENT = 4


@pytest.fixture
def sweep(make_sweep: Callable[..., Sweep]) -> Sweep:
    sweep = make_sweep(YAW, ("transient: 200, duration: 600", "transient: 1000, duration: 3000"))
    assert (sweep.clock.segments, sweep.clock.transient_segments) == (SEGMENTS, TRANSIENT)
    return sweep


def _evidence(sweep: Sweep, rates: np.ndarray, noise: float = 0.0, seed: int = 0) -> Evidence:
    """Return evidence of cells whose exponents have these rates in each segment, (n, segments)."""
    n, clock = len(rates), sweep.clock
    evidence = {v.name: v.empty(n, sweep.extents) for v in sweep.measures.evidence}
    batch = clock.batch_steps * clock.dt
    rng = np.random.default_rng(seed)
    largest = np.repeat(rates, clock.segment_batches, axis=1)
    growth = batch * np.stack([largest, np.zeros_like(largest), -0.19 - largest], axis=2)
    growth += noise * batch * rng.normal(size=growth.shape)
    evidence["growth"][:] = growth
    evidence["growth_total"][:] = growth.cumsum(axis=1)[:, clock.segment_batches - 1 :: clock.segment_batches]
    evidence["status"][:] = Status.TIME_OVER
    evidence["steps"][:] = clock.steps
    evidence["state"][:] = 0.0
    return evidence


def _region(sweep: Sweep, evidence: Evidence) -> list[Region]:
    return [Region(value) for value in classify(sweep, evidence)["region"]]


def test_signs_of_the_largest_exponent(sweep: Sweep) -> None:
    rates = np.array([0.04, 0.0, 1e-4, -0.02, 0.005])[:, None] * np.ones((5, SEGMENTS))
    expected = [Region.CHAOS, Region.PERIODIC, Region.PERIODIC, Region.UNDECIDED, Region.UNDECIDED]
    assert _region(sweep, _evidence(sweep, rates)) == expected


def test_noise_hides_a_small_exponent_but_does_not_make_it_neutral(sweep: Sweep) -> None:
    rates = 0.02 * np.ones((4, SEGMENTS))
    quiet = _region(sweep, _evidence(sweep, rates, noise=0.001))
    loud = _region(sweep, _evidence(sweep, rates, noise=0.2))
    assert set(quiet) == {Region.CHAOS}
    assert set(loud) == {Region.UNDECIDED}


def test_chaos_that_has_ended_is_not_chaos(sweep: Sweep) -> None:
    rates = np.full((2, SEGMENTS), 0.04)
    rates[0, -3:] = 0.0
    rates[1, -3:] = -0.016
    result = classify(sweep, _evidence(sweep, rates))
    assert list(result["region"]) == [Region.UNDECIDED] * 2
    assert list(result["was_chaotic"]) == [1, 1]


def test_a_sink_has_exact_exponents_and_keeps_the_raw_ones(sweep: Sweep) -> None:
    evidence = _evidence(sweep, np.full((3, SEGMENTS), -0.015))
    steps = sweep.clock.segment_steps
    evidence["certificate"][:] = Certificate.SINK
    evidence["status"][:] = Status.ENDED_SINK
    evidence["eigenvalue_re"][:] = [-0.016, -0.016, -0.158]
    evidence["steps"][:] = [10 * steps, 3 * steps, 4 * steps]
    evidence["certified_steps"][:] = evidence["steps"]
    evidence["settled_steps"][:] = evidence["steps"] - steps
    result = classify(sweep, evidence)
    assert list(result["region"]) == [Region.SINK] * 3
    np.testing.assert_array_equal(result["lyapunov"], evidence["eigenvalue_re"])
    assert (result["lyapunov_se"] == 0).all()
    np.testing.assert_allclose(result["lyapunov_raw"][0], [-0.015, 0.0, -0.175], atol=1e-9)
    assert np.isnan(result["lyapunov_raw"][1:]).all()  # ended within the transient
    np.testing.assert_allclose(result["settle_time"], [2250, 500, 750])
    np.testing.assert_allclose(result["time_used"], [2500, 750, 1000])
    assert list(result["was_chaotic"]) == [0, 0, 0]


def test_a_sink_reached_through_chaos_was_chaotic(sweep: Sweep) -> None:
    rates = np.full((3, SEGMENTS), -0.016)
    rates[0, :8] = 0.05
    rates[1, 0] = 0.05  # one growth at the start is no chaos
    rates[2, 9:] = 0.05  # nor is what comes after settling
    evidence = _evidence(sweep, rates)
    evidence["certificate"][:] = Certificate.SINK
    evidence["eigenvalue_re"][:] = -0.016
    evidence["settled_steps"][:] = 9 * sweep.clock.segment_steps
    assert list(classify(sweep, evidence)["was_chaotic"]) == [1, 0, 0]


def test_statuses_that_decide_by_themselves(sweep: Sweep) -> None:
    evidence = _evidence(sweep, np.zeros((5, SEGMENTS)))
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


def test_every_cell_has_every_variable(sweep: Sweep) -> None:
    result = classify(sweep, _evidence(sweep, np.zeros((3, SEGMENTS))))
    for variable in result_variables(sweep):
        assert result[variable.name].shape == variable.shape(3, sweep.extents)
        assert result[variable.name].dtype == variable.dtype


def test_the_rules_do_not_depend_on_company(sweep: Sweep) -> None:
    rng = np.random.default_rng(3)
    evidence = _evidence(sweep, rng.normal(scale=0.03, size=(50, SEGMENTS)), noise=0.02)
    whole = classify(sweep, evidence)
    for start, stop in ((0, 1), (7, 30), (49, 50)):
        part = classify(sweep, {name: values[start:stop] for name, values in evidence.items()})
        for name, values in part.items():
            np.testing.assert_array_equal(values, whole[name][start:stop], err_msg=name)


@pytest.mark.parametrize("correlation", [0.0, -0.4])
def test_the_standard_error_is_the_scatter_of_the_mean(correlation: float) -> None:
    rng = np.random.default_rng(1)
    noise = rng.normal(size=(4000, 49))
    rates = noise[:, 1:] + correlation * noise[:, :-1]
    errors = Sums(rates[:, :, None]).error(np.zeros(4000, dtype=int), np.full(4000, 48))[:, 0]
    assert errors.mean() / rates.mean(axis=1).std() == pytest.approx(1.0, abs=0.15)


def test_too_few_batches_have_no_error() -> None:
    sums = Sums(np.ones((1, 10, 2)))
    assert np.isinf(sums.error(np.array([4]), np.array([7]))).all()
    assert (sums.error(np.array([4]), np.array([8])) < 1e-7).all()


def test_the_error_over_a_window_is_that_of_its_batches_alone() -> None:
    rates = np.random.default_rng(5).normal(size=(1, 30, 1))
    part = Sums(rates[:, 7:19]).error(np.array([0]), np.array([12]))
    np.testing.assert_allclose(Sums(rates).error(np.array([7]), np.array([19])), part, rtol=1e-10)
    x = rates[0, 7:19, 0] - rates[0, 7:19, 0].mean()
    expected = max(x @ x + 2 * x[1:] @ x[:-1], x @ x / 4) / 11 / 12
    np.testing.assert_allclose(part[0, 0], np.sqrt(expected), rtol=1e-10)


def test_a_window_too_short_to_tell_is_undecided(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(LORENZ, ("transient: 20, duration: 80", "transient: 0, duration: 4"))
    evidence = _evidence(sweep, np.full((1, sweep.clock.segments), 0.9))
    evidence["growth_total"][..., 2] = -14.5 * np.arange(1, sweep.clock.segments + 1) * sweep.clock.segment_steps * 0.02
    assert _region(sweep, evidence) == [Region.UNDECIDED]
