"""The one rule that tells positive, neutral and negative exponents apart.

An exponent L over a time T is neutral if |L| < max(`errors` standard errors, `neutral` F / T), where F is the largest
departure of the sum of growth from its straight line within that time. Along a bounded orbit the growth in the
direction of the flow stays bounded: after T it may be off by its whole range, and if it comes near both ends of the
range early or late, it departs from the line by half of that; hence `neutral` = 2, for all models.
A large error makes an exponent neutral, so neutral alone is no reason to call an orbit regular; and an orbit that
leaves a weakly unstable cycle has a small positive exponent and almost no departure, so chaos must also have grown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quavsweep.classify.growth import Average
from quavsweep.config.schema import Thresholds

ROUNDING = 1e-8  # growth that may come from rounding alone, as where a neutral exponent is 0 in every step
GROWN = 3.0  # growth of ln without which nothing is chaotic


@dataclass(frozen=True)
class Sign:
    """Signs of exponents, (n, K) bool each; all are False where the exponent or its error is not known."""

    positive: np.ndarray
    neutral: np.ndarray
    negative: np.ndarray


def signs(average: Average, thresholds: Thresholds) -> Sign:
    """Return the signs of averaged exponents."""
    bound = np.maximum(thresholds.errors * average.error, bound_of_departure(average, thresholds))
    known = np.isfinite(bound)
    return Sign(
        known & (average.rate > bound), known & (np.abs(average.rate) <= bound), known & (average.rate < -bound)
    )


def chaotic(average: Average, thresholds: Thresholds) -> np.ndarray:
    """Whether the first exponent is positive, and growth so large that it tells chaos, (n,) bool."""
    grown = average.rate[:, 0] * average.time >= GROWN
    return np.asarray(signs(average, thresholds).positive[:, 0] & grown)


def bound_of_departure(average: Average, thresholds: Thresholds) -> np.ndarray:
    """Return below what an exponent is neutral whatever its error, (n, K) [1/time]."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.maximum(thresholds.neutral * average.departure, ROUNDING) / average.time[:, None])
