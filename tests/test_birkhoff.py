"""Weighted averages along regular and irregular series, and the end of a phase of growth."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep.analysis.birkhoff import agreeing_digits, vanishing_digits
from quavsweep.analysis.change_point import end_of_slope, last_of_growth
from quavsweep.classify import regions
from quavsweep.codes import Region
from quavsweep.config import parse_sweep
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.plan import make_plan


def _quasi_periodic(n: int) -> np.ndarray:
    phase = np.random.default_rng(0).uniform(0, 2 * np.pi, size=(200, 2, 1))
    t = np.arange(n + 1)
    return np.diff(np.cos(2.0 * t + phase[:, :1]) + 0.5 * np.sin(3.3 * t + phase[:, 1:]), axis=-1)


def test_averages_over_quasi_periodic_series_agree_to_many_digits() -> None:
    digits = [np.median(agreeing_digits(_quasi_periodic(n))) for n in (32, 64, 128, 256)]
    assert digits == sorted(digits)
    assert digits[1] > 2.0
    assert digits[3] > 4.0
    assert np.median(vanishing_digits(_quasi_periodic(128))) > 4.0


@pytest.mark.parametrize("n", [64, 128, 256])
def test_averages_over_noise_do_not(n: int) -> None:
    noise = np.random.default_rng(1).normal(size=(2000, 1, n + 1))
    assert np.quantile(agreeing_digits(noise), 0.99) < 1.8
    assert np.quantile(agreeing_digits(np.diff(noise, axis=-1)), 0.99) < 3.4


def test_a_constant_agrees_but_does_not_vanish() -> None:
    rates = np.array([-1e-3, 1e-15, -2.0])[None, :, None] * np.ones(48)
    assert (agreeing_digits(rates) == 7).all()
    vanishing = vanishing_digits(rates)[0]
    assert vanishing[1] == 7
    assert (vanishing[[0, 2]] < 0).all()
    assert np.isnan(agreeing_digits(rates[..., :15])).all()


@pytest.mark.parametrize("power", [0.5, 1.5, 3.0])
@pytest.mark.parametrize("end", [1.5, 4.0, 40.0])  # of the beginning, as times of a window
def test_growth_of_an_orbit_that_slows_down_does_not_vanish(power: float, end: float) -> None:
    rates = -power * np.diff(np.log(np.linspace(1.0, end, 49)))
    assert vanishing_digits(rates[None])[0] < 0.5


def test_slowing_down_at_a_pitchfork_is_no_cycle() -> None:
    text = """
name: slow
model: quadrotor_yaw
parameters: {Ix: 0.004, Omega1: 6.2, c: 5}
initial: {p: 0.001, q: 0.001, r: 0.001}
integrate: {method: rk4, dt: 0.02, transient: 1000, duration: 3000}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
    sweep = parse_sweep(text)
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, 1), lambda: False)
    assert regions(sweep, evidence).tolist() == [Region.UNDECIDED]


@pytest.mark.parametrize("end", [10, 30, 55])
def test_the_end_of_growth_is_found_to_a_few_batches(end: int) -> None:
    rng = np.random.default_rng(end)
    slope = np.where(np.arange(60) < end, 3.0, -1.0)
    path = np.concatenate([np.zeros((500, 1)), np.cumsum(slope + rng.normal(size=(500, 60)), axis=1)], axis=1)
    first, last = np.zeros(500, int), np.full(500, 60)
    assert np.quantile(np.abs(last_of_growth(path, first, last) - end), 0.9) <= 1
    assert np.quantile(np.abs(end_of_slope(path, first, last, np.full(500, 1.0)) - end), 0.9) <= 2


def test_each_path_has_ends_of_its_own() -> None:
    path = np.array([[0.0, 1, 2, 1, 0, np.nan], [9, 0, 0, 5, 4, 3], [0, -1, -1, 0, np.nan, np.nan]])
    first, last = np.array([0, 2, 0]), np.array([4, 5, 3])
    assert last_of_growth(path, first, last).tolist() == [2, 3, 0]
    assert end_of_slope(path, first, last, np.zeros(3)).tolist() == [2, 3, 0]
