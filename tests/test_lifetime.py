"""Lifetimes: on synthetic starts whose mean lifetime is known, and by closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from quavsweep.analysis.lifetime import (
    Survival,
    chi_squared_tail,
    constancy,
    least_residual,
    mean_residual,
    settled_look,
    share_error,
    spiral_time,
)

LOOK = 50.0
END = 4000.0


def _survival(times: np.ndarray, look: float = LOOK, end: float = END) -> Survival:
    last = round(end / look)
    stayed = np.floor(times / look).astype(int)
    return Survival.of(np.minimum(stayed, last), stayed < last)


def _starts(rng: np.random.Generator, number: int, direct: float, lifetime: float, kind: str) -> np.ndarray:
    """Return when starts settle: some directly, the others chaotic with an exponential lifetime, then a spiral."""
    few = rng.binomial(number, direct)
    early = {
        "even": rng.uniform(120, 350, few),
        "normal": rng.normal(250, 40, few),
        "tail": 150 + rng.exponential(60, few),
    }[kind]
    return np.concatenate([early, 150 + rng.exponential(lifetime, number - few)])


def test_survival_counts_starts_at_risk() -> None:
    survival = Survival.of(np.array([0, 1, 1, 3, 3]), np.array([True, True, False, True, False]))
    np.testing.assert_array_equal(survival.at_risk, [5, 3, 2, 1])
    np.testing.assert_array_equal(survival.leave, [1, 1, 0, 1])
    np.testing.assert_allclose(survival.remaining, [1, 4 / 5, 8 / 15, 8 / 15, 0])
    assert survival.beyond(1).exposure == 6
    assert Survival.of(np.zeros(0, int), np.zeros(0, bool)).exposure == 0


def test_nobody_leaves() -> None:
    survival = Survival.of(np.full(100, 80), np.zeros(100, bool))
    assert settled_look(survival) == 0
    assert math.isnan(mean_residual(survival)[0])
    assert math.isnan(constancy(survival))
    assert least_residual(survival) == pytest.approx(8000 / -math.log(0.05), rel=0.02)


def test_all_leave_directly() -> None:
    rng = np.random.default_rng(1)
    survival = _survival(rng.uniform(120, 350, 1000))
    first = settled_look(survival)
    assert first * LOOK >= 300
    assert math.isnan(mean_residual(survival.beyond(first))[0])


@pytest.mark.parametrize("hazard", [0.01, 0.3, 0.8])
def test_the_estimate_is_the_exponential_of_the_hazard(hazard: float) -> None:
    at_risk = np.array([1000, 500])
    leave = (at_risk * hazard).astype(int)
    mean, error = mean_residual(Survival(at_risk, leave))
    assert math.exp(-1 / mean) == pytest.approx(1 - hazard)
    step = 1e-6
    slope = (1 / math.log1p(-hazard - step) - 1 / math.log1p(-hazard)) / step
    assert error == pytest.approx(slope * math.sqrt(hazard * (1 - hazard) / 1500), rel=1e-4)


@pytest.mark.parametrize(
    ("number", "direct", "kind", "lifetime"),
    [
        (256, 0.0, "even", 300.0),
        (256, 0.5, "even", 2000.0),
        (256, 0.5, "tail", 10000.0),
        (256, 0.9, "normal", 2000.0),
        (1024, 0.5, "normal", 300.0),
        (1024, 0.9, "tail", 2000.0),
        (1024, 0.9, "even", 10000.0),
    ],
)
def test_two_errors_cover_the_true_lifetime(number: int, direct: float, kind: str, lifetime: float) -> None:
    rng = np.random.default_rng(7)
    means, errors, constant = [], [], []
    for _ in range(400):
        survival = _survival(_starts(rng, number, direct, lifetime, kind))
        beyond = survival.beyond(settled_look(survival))
        mean, error = (LOOK * x for x in mean_residual(beyond))
        means.append(mean)
        errors.append(error)
        constant.append(constancy(beyond))
    known = np.isfinite(means)
    assert known.mean() > 0.95
    distance = (np.array(means)[known] - lifetime) / np.array(errors)[known]
    assert 0.9 <= np.mean(np.abs(distance) < 2) <= 0.98
    assert abs(np.median(distance)) < 0.2
    tested = np.array(constant)[np.isfinite(constant)]
    assert np.mean(tested < 0.05) < 0.08


def test_the_time_of_direct_starts_is_found() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        survival = _survival(_starts(rng, 1024, 0.7, 3000.0, "even"))
        assert 350 <= settled_look(survival) * LOOK <= 1500


def test_two_lifetimes_are_not_one() -> None:
    rng = np.random.default_rng(3)
    times = np.concatenate([rng.exponential(300, 500), rng.exponential(6000, 500)])
    assert constancy(_survival(times)) < 1e-6


@pytest.mark.parametrize("look", [10.0, 200.0, 500.0])
def test_the_estimate_does_not_depend_on_the_distance_of_looks(look: float) -> None:
    times = np.random.default_rng(4).exponential(700.0, 20_000)
    mean, error = (look * x for x in mean_residual(_survival(times, look)))
    assert abs(mean - 700) < 3 * error
    assert error < 12


def test_the_bound_is_exceeded_in_19_of_20_cases() -> None:
    rng = np.random.default_rng(5)
    bounds = [least_residual(_survival(rng.exponential(60_000.0, 100))) * LOOK for _ in range(1000)]
    assert 0.93 < np.mean(np.array(bounds) < 60_000) < 0.985


@pytest.mark.parametrize("freedom", [1, 2, 3, 8, 9])
def test_the_tail_of_chi_squared_is_scipys(freedom: int) -> None:
    chi2 = pytest.importorskip("scipy.stats").chi2
    for square in (0.0, 0.3, 2.0, 7.0, 20.0):
        assert chi_squared_tail(square, freedom) == pytest.approx(chi2.sf(square, freedom), abs=1e-12)


def test_errors_of_shares_are_never_zero() -> None:
    error = share_error(np.array([0, 50, 100, 0]), np.array([100, 100, 100, 0]))
    np.testing.assert_allclose(error[[0, 1]], [np.sqrt(2 / 104 * 102 / 104 / 104), 0.5 / np.sqrt(104)])
    assert error[0] == pytest.approx(error[2])
    assert np.isnan(error[3])


def test_a_spiral_takes_the_logarithm_of_the_ratio_over_the_rate() -> None:
    start, sink = np.array([[5.0, 0.0], [1.0, 1.0]]), np.zeros((2, 2))
    end = np.array([[0.01, 0.0], [0.0, 0.02 * math.exp(-3.0)]])
    rate, late = np.array([0.1, 0.1]), np.array([0.0, 30.0])
    time = spiral_time(start, end, sink, rate, late)
    assert time == pytest.approx(math.log(5.0 / 0.02) / 0.1)
    assert spiral_time(start, end, sink, rate, late + 1000.0) == 0.0
    assert spiral_time(start, start, sink, rate, late) == 0.0
    assert spiral_time(start[:0], end[:0], sink[:0], rate[:0], late[:0]) == 0.0


def test_direct_starts_are_given_the_time_of_their_spiral() -> None:
    survival = _survival(np.random.default_rng(6).exponential(3000.0, 500))
    assert settled_look(survival, direct=8.0) >= 10
