"""Lifetimes of transient chaos: mean residual time, censored, of starts that are still chaotic beyond a time.

Looks are one segment apart. A start is at risk in an interval between two looks if it is outside every certified
neighbourhood at the first of them; the share of those that have left at the second is the hazard of the interval.
Chaos forgets its past, so its hazard is constant; starts that spiral into an attractor directly all leave early, which
shows as a hazard that is not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

FEWEST = 10  # leavers: with so many, 2 standard errors cover the truth in nine cases of ten
GROUPS = 10  # of intervals at most, that the test of a constant hazard compares
PER_GROUP = 8.0  # leavers expected in each at least
QUANTILE = 1.645  # of the normal distribution, 95 % on one side
FADED = 20.0  # times of decay after which a distance is too small to tell what it was
CHAOTIC_DECAYS = 3.0  # times of the slowest decay that chaotic starts stay on average, at least
MARGIN = 0.25  # of the time until which the hazard is seen to vary, added to it


@dataclass(frozen=True)
class Survival:
    """How many starts are at risk, and leave, between one look and the next.

    Parameters
    ----------
    at_risk, leave : (looks,) int64
        In the interval that begins at each look; the first look is t = 0.
    """

    at_risk: np.ndarray
    leave: np.ndarray

    @classmethod
    def of(cls, stayed: np.ndarray, left: np.ndarray) -> Survival:
        """Return the survival of some starts.

        Parameters
        ----------
        stayed : (n,) int
            Number of the last look that saw the start outside; the first is 0.
        left : (n,) bool
            Whether the look after it saw the start inside; if not, nothing is known from then on.
        """
        intervals = int(np.max(stayed + left, initial=0))
        exposed = np.bincount(stayed + left, minlength=intervals + 1)
        return cls(exposed[:0:-1].cumsum()[::-1], np.bincount(stayed[left], minlength=intervals)[:intervals])

    def beyond(self, first: int) -> Survival:
        """Return the survival from a look on."""
        return Survival(self.at_risk[first:], self.leave[first:])

    @property
    def exposure(self) -> int:
        """Intervals spent at risk, of all starts together."""
        return int(self.at_risk.sum())

    @property
    def leavers(self) -> int:
        """Starts that leave."""
        return int(self.leave.sum())

    @property
    def remaining(self) -> np.ndarray:
        """Estimated share of starts that are outside at each look, (looks + 1,), from 1 on (Kaplan and Meier)."""
        stay = 1.0 - self.leave / np.maximum(self.at_risk, 1)
        return np.concatenate([[1.0], np.cumprod(stay)])


def spiral_time(
    start: np.ndarray, end: np.ndarray, equilibrium: np.ndarray, rate: np.ndarray, late: np.ndarray
) -> float:
    """Return the time in which the slowest linear mode of sinks brings the farthest start into their neighbourhoods.

    Parameters
    ----------
    start, end, equilibrium : (n, D) float64
        Of starts that ended in a sink: the first and the last state, and the sink.
    rate : (n,) float64
        At which the slowest mode there decays.
    late : (n,) float64
        Time between the first look inside the certified neighbourhood and the last state.

    Returns
    -------
    float
        ln(R/r) over the slowest rate, at least 0; R is the largest distance of a start, r the largest at a first look
        inside, both in the largest coordinate. 0 where no last state tells r, since all are so late that rounding
        is all that is left of the distance.
    """
    told = rate * late < FADED
    inside = (np.abs(end - equilibrium).max(axis=1, initial=0.0) * np.exp(np.where(told, rate * late, 0.0)))[told]
    near, far = float(inside.max(initial=0.0)), float(np.abs(start - equilibrium).max(initial=0.0))
    return math.log(far / near) / float(rate.min()) if 0.0 < near < far else 0.0


def settled_look(survival: Survival, direct: float = 0.0) -> int:
    """Return the look from which on the hazard is constant, so that direct starts have gone.

    Parameters
    ----------
    survival : Survival
    direct : float
        Looks that a direct start may need, see `spiral_time`; it is at least this, with the same margin.

    Notes
    -----
    Of the models "any hazard in each of the first k intervals, one hazard in all later ones", k has the largest
    likelihood less 1 per free hazard (Akaike's criterion). A quarter of k is added, for the tail of what made the
    hazard vary need not be seen.

    References
    ----------
    .. [1] H. Akaike, IEEE Trans. Autom. Control 19, 716 (1974).
    """
    at_risk, leave = survival.at_risk.astype(np.float64), survival.leave.astype(np.float64)
    free = np.concatenate([[0.0], _likelihood(leave, at_risk).cumsum()])
    later = [np.concatenate([part[::-1].cumsum()[::-1], [0.0]]) for part in (leave, at_risk)]
    score = free + _likelihood(*later) - np.arange(len(free))
    k = int(np.argmax(score))
    return min(math.ceil(max(k, direct) * (1.0 + MARGIN)), len(at_risk))


def _likelihood(leave: np.ndarray, at_risk: np.ndarray) -> np.ndarray:
    """Return the largest ln of the likelihood of so many leavers with one hazard."""
    stay = at_risk - leave
    return np.asarray(_xlogx(leave) + _xlogx(stay) - _xlogx(at_risk))


def _xlogx(x: np.ndarray) -> np.ndarray:
    return np.asarray(x * np.log(np.where(x > 0, x, 1.0)))


def mean_residual(survival: Survival) -> tuple[float, float]:
    """Return the mean time that starts at risk still stay, and its standard error, in intervals.

    NaN where fewer than ten starts leave, or all of them do so within one interval.

    Notes
    -----
    With a constant hazard the number of whole intervals is geometric. With D leavers among E intervals at risk the
    likelihood is largest at the hazard h = D/E, whose variance is h (1 - h)/E; the mean of the exponential
    distribution with this hazard is -1/ln(1 - h).
    """
    leavers, exposure = survival.leavers, survival.exposure
    if leavers < FEWEST or leavers == exposure:
        return math.nan, math.nan
    hazard = leavers / exposure
    mean = -1.0 / math.log1p(-hazard)
    return mean, mean**2 * math.sqrt(hazard / exposure / (1.0 - hazard))


def least_residual(survival: Survival) -> float:
    """Return a bound that the mean residual time exceeds with a confidence of 95 %, in intervals; NaN without starts.

    That of the hazard which the upper limit of a Poisson number of leavers gives, with Wilson and Hilferty's quantile
    of chi-squared.
    """
    if not survival.exposure:
        return math.nan
    freedom = 2.0 * (survival.leavers + 1)
    upper = 0.5 * freedom * (1.0 - 2.0 / (9.0 * freedom) + QUANTILE * math.sqrt(2.0 / (9.0 * freedom))) ** 3
    hazard = upper / survival.exposure
    return -1.0 / math.log1p(-hazard) if hazard < 1.0 else 0.0


def outlasts(residual: float, decay: float) -> bool:
    """Whether starts stay longer than the tail of those that decay directly; both times in the same unit."""
    return residual >= CHAOTIC_DECAYS * decay


def constancy(survival: Survival) -> float:
    """Return the probability of hazards that vary at least so much if the true one is constant (chi-squared test).

    NaN where fewer than ten starts leave. Intervals are taken together in groups in which equally many leavers are
    expected.
    """
    leavers, exposure = survival.leavers, survival.exposure
    groups = min(GROUPS, int(leavers / PER_GROUP), len(survival.leave))
    if leavers < FEWEST or groups < 2 or leavers == exposure:
        return math.nan
    hazard = leavers / exposure
    expected = hazard * survival.at_risk
    middle = expected.cumsum() - 0.5 * expected
    group = np.minimum((middle / leavers * groups).astype(int), groups - 1)
    seen, due = (np.bincount(group, part, minlength=groups) for part in (survival.leave, expected))
    filled = due > 0
    square = float((((seen - due) ** 2)[filled] / (due[filled] * (1.0 - hazard))).sum())
    return chi_squared_tail(square, int(filled.sum()) - 1)


def chi_squared_tail(square: float, freedom: int) -> float:
    """Return the probability that chi-squared exceeds a value; a finite sum for whole degrees of freedom.

    References
    ----------
    .. [1] M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 26.4.4 and 26.4.5.
    """
    if freedom < 1:
        return math.nan
    half = 0.5 * square
    term, total = math.exp(-half), 0.0
    if freedom % 2:
        total, term = math.erfc(math.sqrt(half)), math.exp(-half) * math.sqrt(half) / math.gamma(1.5)
    first = 1.5 if freedom % 2 else 1.0
    for i in range(freedom // 2):
        total += term
        term *= half / (first + i)
    return min(total, 1.0)


def share_error(count: np.ndarray, total: np.ndarray) -> np.ndarray:
    """Return the standard error of binomial shares, never 0: that of two more of each kind (Agresti and Coull).

    NaN where there is nothing to have a share of.

    References
    ----------
    .. [1] A. Agresti, B. A. Coull, Am. Stat. 52, 119 (1998).
    """
    share = (count + 2.0) / (total + 4.0)
    return np.where(np.asarray(total) > 0, np.sqrt(share * (1.0 - share) / (total + 4.0)), np.nan)
