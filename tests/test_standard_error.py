"""Standard errors: the scatter of means over many series whose statistics are known, and over many chaotic orbits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from quavsweep.analysis.standard_error import noise_of
from quavsweep.classify.growth import growth_of
from quavsweep.classify.window import averaged
from quavsweep.config import parse_sweep
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.plan import make_plan

N = 3000  # series


def _error(series: np.ndarray) -> np.ndarray:
    """Return the standard error of the mean of each series."""
    return noise_of(series).error(series.shape[-1])


def _white(rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.normal(size=(N, n))


def _positively_correlated(rng: np.random.Generator, n: int) -> np.ndarray:
    x = rng.normal(size=(N, n))
    for i in range(1, n):
        x[:, i] = 0.4 * x[:, i - 1] + np.sqrt(1 - 0.4**2) * x[:, i]
    return x


def _anti_correlated(rng: np.random.Generator, n: int) -> np.ndarray:
    x = rng.normal(size=(N, n + 1))
    return x[:, 1:] - 0.9 * x[:, :-1]


def _bounded(rng: np.random.Generator, n: int) -> np.ndarray:
    return np.diff(rng.normal(size=(N, n + 1)), axis=1)


def _with_a_line(rng: np.random.Generator, n: int) -> np.ndarray:
    phase = rng.uniform(0, 2 * np.pi, size=(N, 1)) + 0.7 * np.arange(n + 1)
    return np.diff(2.0 * np.cos(phase), axis=1) + 0.6 * rng.normal(size=(N, n))


@pytest.mark.parametrize(
    ("make", "n", "ratio", "within_two"),
    [
        (_white, 256, (0.95, 1.05), (0.93, 0.97)),
        (_white, 64, (0.95, 1.1), (0.92, 0.97)),
        (_white, 16, (0.9, 1.15), (0.87, 0.95)),
        (_positively_correlated, 256, (0.9, 1.05), (0.92, 0.97)),
        (_positively_correlated, 64, (0.83, 1.05), (0.89, 0.97)),
        (_anti_correlated, 256, (0.95, 1.1), (0.93, 0.98)),
        (_anti_correlated, 64, (1.0, 1.3), (0.95, 1.0)),
        (_bounded, 256, (1.0, 1.3), (0.99, 1.0)),
        (_bounded, 64, (1.0, 1.35), (0.99, 1.0)),
        (_bounded, 16, (1.0, 1.7), (0.98, 1.0)),
        (_with_a_line, 64, (0.9, 1.6), (0.93, 1.0)),
    ],
)
def test_the_standard_error_is_the_scatter_of_the_mean(
    make: Callable[[np.random.Generator, int], np.ndarray],
    n: int,
    ratio: tuple[float, float],
    within_two: tuple[float, float],
) -> None:
    series = make(np.random.default_rng(n), n)
    mean, error = series.mean(axis=1), _error(series)
    assert ratio[0] <= error.mean() / mean.std() <= ratio[1]
    assert within_two[0] <= (np.abs(mean) < 2 * error).mean() <= within_two[1]


def test_the_error_of_a_bounded_quantity_falls_as_the_time() -> None:
    rng = np.random.default_rng(0)
    errors = [_error(_bounded(rng, n)).mean() for n in (32, 64, 128, 256)]
    np.testing.assert_allclose(-np.diff(np.log2(errors)), 1.0, atol=0.15)


def test_units_and_offsets_do_not_matter() -> None:
    series = _white(np.random.default_rng(1), 40)[:20]
    error = _error(series)
    np.testing.assert_allclose(_error(1e-30 * series), 1e-30 * error, rtol=1e-9)
    np.testing.assert_allclose(_error(series + 1e3), error, rtol=1e-6)
    np.testing.assert_array_equal(_error(series[3:4]), error[3:4])


def test_a_constant_has_no_error_and_few_values_do_not_tell_one() -> None:
    assert (_error(np.full((2, 64), 0.3)) < 1e-16).all()
    assert np.isinf(_error(np.ones((2, 7)))).all()
    assert np.isnan(_error(np.full((2, 64), np.nan))).all()


def test_the_error_of_a_part_is_read_off_the_whole() -> None:
    series = _white(np.random.default_rng(2), 48)
    error = noise_of(series).error(12)
    assert error.mean() / series[:, -12:].mean(axis=1).std() == pytest.approx(1.0, abs=0.1)


LORENZ = """
name: coverage
model: lorenz
initial: {y: 1.0}
axes:
  x: {start: 0.5, stop: 8, num: 20}
  z: {start: 15, stop: 30, num: 10}
integrate: {dt: 0.005, transient: 100, duration: 12000}
measures: {lyapunov: {exponents: 3, block: 20}}
"""

# From such starts the orbit is chaotic for as long as anyone has looked.
YAW = """
name: coverage
model: quadrotor_yaw
parameters: {Omega1: 240, c: 5}
initial: {r: 0.001}
axes:
  p: {start: 0.0005, stop: 0.01, num: 20}
  q: {start: 0.0005, stop: 0.01, num: 10}
integrate: {dt: 0.02, transient: 2000, duration: 12000}
measures: {lyapunov: {exponents: 3, block: 25}}
"""


@pytest.mark.slow
@pytest.mark.parametrize("text", [LORENZ, YAW])
def test_200_chaotic_runs_scatter_as_their_errors_say(text: str) -> None:
    sweep = parse_sweep(text)
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, 200), lambda: False)
    average = growth_of(evidence, sweep.clock).over(averaged(evidence, sweep.clock))
    rate, error = average.rate, average.error
    assert (rate[:, 0] > 0.01).all()
    ratio = error.mean(axis=0) / rate.std(axis=0)
    within = (np.abs(rate - rate.mean(axis=0)) < 2 * error).mean(axis=0)
    neutral = (np.abs(rate[:, 1]) < 3 * error[:, 1]).mean()
    print(f"\n{sweep.model.name}: mean error / scatter {ratio}, within 2 errors {within}, neutral {neutral}")
    for k in (0, 2):
        assert 0.9 <= within[k] <= 0.98
        assert 0.85 <= ratio[k] <= 1.25
    assert neutral >= 0.95
