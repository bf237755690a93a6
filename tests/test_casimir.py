"""Casimir energy and power along orbits, and Remark 3's cases: made series, known systems, orbits of the craft."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quavsweep.analysis.dimension import chaotic_dimension, chaotic_dimension_error, lyapunov_dimension
from quavsweep.analysis.maxima import maxima
from quavsweep.analysis.quadrotor.casimir import (
    energy_extremes,
    energy_imbalance,
    mean_power,
    mean_power_bound,
    sign_changes,
)
from quavsweep.analysis.quadrotor.remark_3 import CASE, REGION_OF_CASE, Case, classify_power, repeats
from quavsweep.codes import Region
from quavsweep.models.lorenz import MODEL as LORENZ

DT = 0.2
T = DT * np.arange(1001)


def _case(series: np.ndarray, dt: float = DT, **options: float) -> Case:
    return Case(int(classify_power(series[None], dt, **options)[0][0]))


def _lorenz(rho: float) -> np.ndarray:
    """Return x dx/dt along an orbit: a power that vanishes in the mean."""
    values = {"sigma": 10.0, "rho": rho, "beta": 8.0 / 3.0}
    rhs = lambda t, u: LORENZ.rhs(*u, **values)  # noqa: E731
    run = solve_ivp(rhs, (0, 80), [1, 1, 20], t_eval=40 + 0.02 * np.arange(2001), method="DOP853", rtol=1e-11)
    return run.y[0] * LORENZ.rhs(*run.y, **values)[0]


@pytest.mark.parametrize(
    ("case", "series"),
    [
        (Case.PERIODIC, np.sin(T)),
        (Case.PERIODIC, 1e-7 * np.sin(T)),
        (Case.PERIODIC, np.sin(T) + 0.5 * np.sin(2 * T + 1) + 0.3 * np.sin(0.5 * T)),
        (Case.PERIODIC, 0.1 + np.sin(T) * (1 + 0.3 * np.sin(T / 5))),
        (Case.IRREGULAR, np.sin(T) + 0.5 * np.sin(np.sqrt(2) * T)),
        (Case.IRREGULAR, np.random.default_rng(0).normal(size=T.size)),
        (Case.IRREGULAR, np.cumsum(np.random.default_rng(1).choice([-1, 1], size=T.size)) - 5.0),
        (Case.CONVERGES, np.zeros(T.size)),
        (Case.CONVERGES, 1e-19 * np.random.default_rng(2).normal(size=T.size)),
        (Case.CONVERGES, np.exp(-0.016 * T) * np.sin(0.4 * T)),
        (Case.CONVERGES, np.exp(-0.02 * T)),
        (Case.NEGATIVE, -np.exp(-0.02 * T)),
        (Case.NEGATIVE, -1.0 - 0.5 * np.sin(T)),
        (Case.POSITIVE, 1.0 + 0.5 * np.sin(T)),
        (Case.POSITIVE, np.exp(0.02 * T)),
        (Case.CONSTANT, np.full(T.size, 0.3)),
        (Case.CONSTANT, np.full(T.size, -0.3)),
        (Case.NONE, np.where(T < 100, np.sin(T), np.nan)),
    ],
)
def test_each_case_is_told_from_its_series(case: Case, series: np.ndarray) -> None:
    assert _case(series) is case


def test_every_case_has_the_region_that_the_remark_gives_it() -> None:
    told = {Case(i): Region(int(region)) for i, region in enumerate(REGION_OF_CASE)}
    assert [code.number for code in CASE] == [int(case) for case in told]
    assert told[Case.POSITIVE] is Region.UNBOUNDED
    assert told[Case.CONSTANT] is told[Case.PERIODIC] is Region.PERIODIC
    assert told[Case.NEGATIVE] is told[Case.CONVERGES] is Region.SINK
    assert told[Case.IRREGULAR] is Region.CHAOS


@pytest.mark.parametrize(("rho", "case"), [(28, Case.IRREGULAR), (160, Case.PERIODIC), (20, Case.CONVERGES)])
def test_the_power_of_lorenz_tells_chaos_cycle_and_sink(rho: float, case: Case) -> None:
    assert _case(_lorenz(rho), 0.02, zero=1e-9) is case


def test_a_series_repeats_after_the_maxima_of_a_period() -> None:
    waves = np.stack([np.sin(2 * T), np.sin(2 * T) + 0.3 * np.sin(T), np.sin(2 * T) + 0.3 * np.sin(2 * T / 5)])
    assert repeats(waves, DT).tolist() == [1, 2, 5]
    assert repeats(waves + 100.0, DT).tolist() == [1, 2, 5]
    assert repeats(np.stack([T, np.sin(np.sqrt(2) * T) + np.sin(T)]), DT).tolist() == [0, 0]


def test_maxima_are_placed_between_the_values() -> None:
    place, height = maxima(np.sin(T))
    exact = np.pi / 2 + 2 * np.pi * np.arange(len(place))
    assert np.abs(place * DT - exact).max() < 0.1 * DT**2
    assert np.abs(height - 1.0).max() < 0.01 * DT**2


def test_energy_is_largest_where_power_falls_through_zero() -> None:
    u = np.stack([np.cos(T), np.sin(T), 0 * T], axis=1)
    found = energy_extremes(u, np.sin(T + 0.05))
    np.testing.assert_allclose(found.maxima[:, 0], -1.0, atol=5e-3 + 0.05**2)
    np.testing.assert_allclose(found.minima[:, 0], 1.0, atol=5e-3 + 0.05**2)
    assert abs(len(found.maxima) - len(found.minima)) <= 1
    assert len(found.maxima) + len(found.minima) == int(sign_changes(np.sin(T + 0.05)))


def test_zeros_are_no_change_of_sign() -> None:
    series = np.array([[1.0, 0, 2, -1, 0, 0, -2], [1, 0, -1, 1, 1, 0, -1], [0, 0, 0, 0, 0, 0, 0]])
    assert sign_changes(series).tolist() == [1, 3, 0]


def test_the_integral_of_power_is_the_change_of_energy() -> None:
    energy = np.cos(T) + 0.1 * np.cos(3 * T)
    power = -np.sin(T) - 0.3 * np.sin(3 * T)
    assert abs(float(energy_imbalance(energy, power, DT))) < 1e-3
    fine = T[0] + 0.5 * DT * np.arange(2001)
    finer = energy_imbalance(np.cos(fine) + 0.1 * np.cos(3 * fine), -np.sin(fine) - 0.3 * np.sin(3 * fine), DT / 2)
    assert abs(float(energy_imbalance(energy, power, DT)) / float(finer)) == pytest.approx(16.0, rel=0.1)
    with pytest.raises(ValueError, match="odd"):
        energy_imbalance(energy[1:], power[1:], DT)


def test_the_mean_power_of_a_bounded_orbit_is_below_its_bound() -> None:
    energy = np.random.default_rng(3).normal(size=(50, 100))
    assert (np.abs(mean_power(energy, 30.0)) <= mean_power_bound(energy, 30.0)).all()
    np.testing.assert_allclose(mean_power(energy, 30.0), (energy[:, -1] - energy[:, 0]) / 30.0)


def test_dimensions_of_known_attractors() -> None:
    exponents = np.array(
        [[0.9056, 0.0, -14.5723], [-0.1, -0.2, -0.3], [0.0, -0.2, -0.3], [0.0, 0.0, -2.0], [2, 1, 0.5]]
    )
    np.testing.assert_allclose(lyapunov_dimension(exponents), [2.06215, 0.0, 1.0, 2.0, 3.0], atol=5e-6)
    assert float(chaotic_dimension(0.9056, -41 / 3)) == pytest.approx(2.06215, abs=5e-6)
    step = 1e-6
    slope = (chaotic_dimension(0.04 + step, -0.19) - chaotic_dimension(0.04 - step, -0.19)) / (2 * step)
    assert float(chaotic_dimension_error(0.04, 0.002, -0.19)) == pytest.approx(0.002 * float(slope), rel=1e-6)
