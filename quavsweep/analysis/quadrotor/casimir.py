"""What follows from the series of Casimir energy (19) and Casimir power (20) along an orbit.

Energy and power themselves are observables of the models.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Extremes:
    """The states in which the energy of an orbit is largest or smallest: where it crosses the ellipsoid of zero power.

    Parameters
    ----------
    maxima, minima : (m, D) float64
        Crossings from inside, where the power changes from + to -, and from outside, in order.
    """

    maxima: np.ndarray
    minima: np.ndarray


def energy_extremes(u: np.ndarray, power: np.ndarray) -> Extremes:
    """Return the extremes of energy along an orbit.

    Parameters
    ----------
    u : (n, D) float64
        States at close times.
    power : (n,) float64
        Casimir power there [W].

    Notes
    -----
    Straight lines between the states: the error falls as dt^2.
    """
    first = np.flatnonzero((power[:-1] > 0) != (power[1:] > 0))
    share = (power[first] / (power[first] - power[first + 1]))[:, None]
    crossing = u[first] + share * (u[first + 1] - u[first])
    falls = power[first] > 0
    return Extremes(crossing[falls], crossing[~falls])


def sign_changes(power: np.ndarray) -> np.ndarray:
    """Return how often each series (..., n) changes its sign, (...) int; zeros keep the sign before them."""
    positive = power > 0
    known = power != 0
    last = np.maximum.accumulate(np.where(known, np.arange(power.shape[-1]), 0), axis=-1)
    positive = np.take_along_axis(positive, last, axis=-1)
    return np.asarray((positive[..., 1:] != positive[..., :-1]).sum(axis=-1))


def mean_power(energy: np.ndarray, duration: float) -> np.ndarray:
    """Return the mean Casimir power over each orbit, (C(b) - C(a)) / (b - a) [W], (...).

    On an attractor energy is bounded, so the mean is zero but for an error of at most its range over the time.

    Parameters
    ----------
    energy : (..., n) float64
        Casimir energy [J].
    duration : float
        Time from the first to the last value, b - a [s].
    """
    return np.asarray((energy[..., -1] - energy[..., 0]) / duration)


def mean_power_bound(energy: np.ndarray, duration: float) -> np.ndarray:
    """Return what the mean power of a bounded orbit may be, at most: the range of energy over the time [W], (...)."""
    return np.asarray(np.ptp(energy, axis=-1) / duration)


def energy_imbalance(energy: np.ndarray, power: np.ndarray, dt: float) -> np.ndarray:
    """Return the integral of the power less the change of the energy [J], (...): zero but for the quadrature's error.

    Parameters
    ----------
    energy, power : (..., n) float64
        At even times [J], [W]; n odd.
    dt : float
        Time between two values [s].

    Notes
    -----
    Simpson's rule; its error falls as dt^4.
    """
    if power.shape[-1] % 2 == 0:
        raise ValueError(f"Simpson's rule needs an odd number of values, not {power.shape[-1]}")
    inner = 4.0 * power[..., 1:-1:2].sum(axis=-1) + 2.0 * power[..., 2:-1:2].sum(axis=-1)
    integral = dt / 3.0 * (power[..., 0] + inner + power[..., -1])
    return np.asarray(integral - (energy[..., -1] - energy[..., 0]))
