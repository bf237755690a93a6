"""The chaotic phase of an orbit: until when, with which largest exponent, also where it has settled since."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from quavsweep.analysis.change_point import end_of_slope, last_of_growth
from quavsweep.analysis.standard_error import FEWEST
from quavsweep.classify.growth import LARGEST, Average, Growth
from quavsweep.classify.sign import GROWN, bound_of_departure, chaotic
from quavsweep.classify.window import ends, used
from quavsweep.codes import Certificate, Region
from quavsweep.config import Sweep
from quavsweep.measures import Evidence

REGULAR = (Region.PERIODIC, Region.QUASI_PERIODIC)  # their largest exponent is that along the flow
SURE = 40.0  # growth of ln that only chaos makes: what leaves a saddle grows by no more than ln of the rounding, 36


@dataclass(frozen=True)
class ChaoticPhase:
    """Where the chaotic phase of each cell ended, and its largest exponent.

    Parameters
    ----------
    found : (n,) bool
        Whether there was one.
    until : (n,) int
        Batches from t = 0 to its end.
    rate, error : (n,) float64
        Largest exponent from the end of the first segment until then [1/time], and its standard error; infinite where
        the phase is too short for one.
    """

    found: np.ndarray
    until: np.ndarray
    rate: np.ndarray
    error: np.ndarray


def chaotic_phase(
    sweep: Sweep, evidence: Evidence, growth: Growth, region: np.ndarray, exact: np.ndarray
) -> ChaoticPhase:
    """Return the chaotic phase of each cell, if it had one.

    It begins with the second segment, because a start near a saddle grows once. Where the orbit is certified, it ends
    where the slope of the summed growth of the largest exponent changes to the exact exponent; where the orbit is
    regular by its averages, to zero; elsewhere where the slope falls beyond its error and the growth before is chaotic,
    or else with what was integrated. It counts as chaotic if it is eight batches or more, the exponent over it is
    positive, and growth goes on in its second half; or if it is shorter and ln grows by 40 or more, which no error can
    explain.

    Parameters
    ----------
    sweep, evidence, growth
    region : (n,) int8
    exact : (n, D) float64
        Exponents of certified cells [1/time].
    """
    clock, errors = sweep.clock, sweep.config.classify.errors
    last = used(evidence, clock)
    certified = evidence["certified_steps"] // clock.batch_steps
    last = np.where(ends(evidence), np.minimum(certified, last), last)
    # What rests on a saddle came along its stable directions: tangent vectors grew in the others, as if in chaos.
    last = np.where(evidence["certificate"] == Certificate.REST, 0, last)
    first = np.minimum(clock.segment_batches, last)
    settled = ends(evidence) | np.isin(region, REGULAR)
    slope = np.where(ends(evidence), exact[:, 0], 0.0)
    until = np.where(settled, _until_exact(growth, first, last, slope), _until_slower(growth, first, last, errors))
    phase = _judged(sweep, growth, first, until)
    again = np.flatnonzero(~phase.found & ~settled & (until < last))
    whole = _judged(sweep, growth.of(again), first[again], last[again])
    for field in fields(ChaoticPhase):
        getattr(phase, field.name)[again] = getattr(whole, field.name)
    return phase


def _rise(growth: Growth, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return the growth of the largest exponent's vector between two batches, (n,)."""
    path, cells = growth.path[:, 0], np.arange(len(first))
    return np.asarray(path[cells, last] - path[cells, first])


def _until_exact(growth: Growth, first: np.ndarray, last: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Return the batches until which growth is faster than in the end, whose exponent is known, (n,) int."""
    path, until = growth.path[:, 0], last
    for _ in range(3):
        before = _rise(growth, first, until) / np.maximum(until - first, 1)
        until = end_of_slope(path, first, last, (before + exact * growth.batch) / 2.0)
    return until


def _until_slower(growth: Growth, first: np.ndarray, last: np.ndarray, errors: float) -> np.ndarray:
    """Return the batches until which growth is faster than after them beyond its error, (n,) int; else all of them."""
    turn = last_of_growth(growth.path[:, 0], first, last)
    open_ = np.flatnonzero(_rise(growth, first, turn) >= GROWN)
    part = growth.of(open_)
    before = part.over((first[open_], turn[open_]), LARGEST)
    after = part.over((turn[open_], last[open_]), LARGEST, wanted=np.zeros(len(open_), bool))
    until = last.copy()
    short = _short(growth, first, turn)[open_] & (after.rate < before.rate / 2)[:, 0]
    until[open_] = np.where(short | _ended(before, after, errors), turn[open_], last[open_])
    return until


def _short(growth: Growth, first: np.ndarray, until: np.ndarray) -> np.ndarray:
    """Whether a phase has too few batches for an error, and so much growth that it needs none, (n,) bool."""
    return np.asarray((until - first < FEWEST) & (_rise(growth, first, until) >= SURE))


def _judged(sweep: Sweep, growth: Growth, first: np.ndarray, until: np.ndarray) -> ChaoticPhase:
    """Return whether and how the growth between two ends is chaotic."""
    thresholds, n = sweep.config.classify, len(first)
    short = _short(growth, first, until)
    phase = ChaoticPhase(short.copy(), until, np.full(n, np.nan), np.full(n, np.nan))
    likely = np.flatnonzero(short | (_rise(growth, first, until) >= GROWN) & (until - first >= FEWEST))
    part, window = growth.of(likely), (first[likely], until[likely])
    whole, half = part.over_last(window, (1, 2), LARGEST)
    goes_on = half.rate > bound_of_departure(half, thresholds)
    phase.found[likely] |= chaotic(whole, thresholds) & goes_on[:, 0]
    phase.rate[likely], phase.error[likely] = whole.rate[:, 0], whole.error[:, 0]
    return phase


def _ended(before: Average, after: Average, errors: float) -> np.ndarray:
    """Whether growth is slower after than before, beyond what both fluctuate by, (n,) bool."""
    with np.errstate(divide="ignore", invalid="ignore"):
        error = before.error * np.sqrt(1.0 + before.time / after.time)[:, None]
        return np.asarray((after.rate < before.rate / 2) & (before.rate - after.rate > errors * error))[:, 0]
