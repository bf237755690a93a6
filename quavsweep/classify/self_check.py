"""What must be zero for every cell: raw sums less the mean divergence, and the exponent in the direction of the flow.

NaN means that there is nothing to check; `missing_sum` and `missing_zero` say why, where that is so for a whole sweep.
"""

from __future__ import annotations

import numpy as np

from quavsweep.classify.growth import Average
from quavsweep.classify.sign import signs
from quavsweep.classify.window import Window
from quavsweep.codes import Certificate, Region
from quavsweep.config import Sweep
from quavsweep.measures import Evidence

WIDEST = 36.0  # range of ln of the speed along an orbit, as far as it differs from 0 beyond rounding


def missing_sum(sweep: Sweep) -> str:
    """Return why no cell of a sweep can have a sum of exponents to check; empty if it can."""
    lyapunov = sweep.measures.lyapunov
    if lyapunov is None:
        return "no exponents are measured"
    if lyapunov.trace:
        return "the last exponent is made of the sum"
    if lyapunov.exponents < len(sweep.model.states):
        return f"{lyapunov.exponents} of {len(sweep.model.states)} exponents are measured"
    return ""


def missing_zero(sweep: Sweep) -> str:
    """Return why no cell of a sweep can have an exponent that must be zero; empty if it can."""
    if sweep.measures.lyapunov is None:
        return "no exponents are measured"
    return "" if sweep.model.forcing_period is None else "a forced system has no exponent in the direction of its flow"


def sum_error(sweep: Sweep, evidence: Evidence, raw: Average, window: Window) -> np.ndarray:
    """Return the sum of the raw exponents less the mean divergence over the same time, (n,) float64 [1/time]."""
    n = len(raw.rate)
    if missing_sum(sweep):
        return np.full(n, np.nan)
    per_segment = sweep.clock.segment_batches
    first, last = (ends // per_segment for ends in window)
    divergence = np.concatenate([np.zeros((n, 1)), evidence["divergence"]], axis=1)
    cells = np.arange(n)
    last = np.maximum(first, last)
    within = last < divergence.shape[1]
    mean = divergence[cells, np.where(within, last, 0)] - divergence[cells, np.where(within, first, 0)]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(raw.rate.sum(axis=1) - mean / raw.time)


def zero_error(sweep: Sweep, evidence: Evidence, region: np.ndarray, average: Average, exact: np.ndarray) -> np.ndarray:
    """Return the smallest |exponent| of orbits away from equilibria, (n,) float64 [1/time].

    Of a certified cycle it is that of its multipliers, of others that of the averages, if they reach down to zero. An
    exponent whose growth departs from its line by more than the speed along an orbit can vary is none along the flow:
    it mixes chaos and the regular orbit behind it.
    """
    if missing_zero(sweep):
        return np.full(len(region), np.nan)
    moving = np.isin(region, (Region.CHAOS, Region.QUASI_PERIODIC, Region.PERIODIC))
    reaches = ~signs(average, sweep.config.classify).positive[:, -1]
    size = np.abs(average.rate)
    cells, smallest = np.arange(len(size)), np.where(np.isnan(size), np.inf, size).argmin(axis=1)
    steady = average.departure[cells, smallest] <= WIDEST
    averaged = np.where(moving & reaches & steady, size[cells, smallest], np.nan)
    closed = evidence["certificate"] == Certificate.CYCLE
    return np.where(closed, np.abs(exact).min(axis=1), averaged)
