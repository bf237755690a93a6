"""The region of each cell: what is certified, or what the signs of the exponents tell; everything else is undecided.

- sink, periodic: certified (a sink's equilibrium attracts the state, a cycle is closed and attracts it);
- unbounded: the orbit left the model's bound;
- saddle: the orbit rests on an equilibrium with an eigenvalue to the right of zero;
- chaos: the largest exponent is positive in the last half and in the last quarter of the averaged time alike;
- periodic without a certificate: one exponent is neutral and all others negative, in both, and growth of the first
  vanishes on average; it does not where an orbit slows down near an equilibrium that barely attracts;
- quasi-periodic: two or more are neutral and all others negative, in both; the orbit is regular, and at no look did a
  stable cycle close near it, as one does where an orbit comes to a cycle slowly.

Noise alone makes no exponent negative, so chaos whose error hides the sign of the largest exponent has two neutral ones
and looks like a torus. Therefore it must be regular too: weighted Birkhoff averages of the growth agree to `digits`
digits in every exponent, and vanish to one digit more in the neutral ones; otherwise it is undecided. Of 1,800 chaotic
orbits, each with its mean exponent taken away, none is regular. A forced system has one neutral exponent fewer, because
its phase is no state: its cycles have none, and need a certificate.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from quavsweep.analysis.birkhoff import agreeing_digits, vanishing_digits
from quavsweep.classify.growth import Growth, late_growth_of
from quavsweep.classify.sign import chaotic, signs
from quavsweep.classify.window import Window, averaged
from quavsweep.codes import Certificate, Region, Status
from quavsweep.config import Sweep
from quavsweep.measures import Evidence

LEAST_EXPONENTS = 2  # that must be known: one that is neutral says nothing of the others
NO_DRIFT = 1.0  # digits to which averaged growth vanishes along a cycle; where an orbit slows down, to half a digit


def region_of(sweep: Sweep, evidence: Evidence, growth: Growth | None) -> np.ndarray:
    """Return the region of each cell, (n,) int8; `growth` where exponents were measured."""
    status, certificate = evidence["status"], evidence["certificate"]
    computed = (status != Status.NOT_COMPUTED) & (status != Status.FAILED)
    region = np.where(computed, Region.UNDECIDED, Region.NONE).astype(np.int8)
    open_ = np.flatnonzero((status == Status.TIME_OVER) & (certificate == Certificate.NONE))
    if open_.size:
        region[open_] = _uncertified(sweep, {name: values[open_] for name, values in evidence.items()}, growth, open_)
    unstable = evidence["eigenvalue_re"][:, 0] > 0
    region[(certificate == Certificate.REST) & unstable] = Region.SADDLE
    region[status == Status.DIVERGED] = Region.UNBOUNDED
    region[certificate == Certificate.SINK] = Region.SINK
    region[certificate == Certificate.CYCLE] = Region.PERIODIC
    return region


def birkhoff_digits(growth: Growth, window: Window) -> np.ndarray:
    """Return to how many digits averages of the growth agree, in the exponent where they agree least, (n,) float64."""
    return np.asarray(_over(agreeing_digits, growth, window).min(axis=1))


def _over(digits: Callable[[np.ndarray], np.ndarray], growth: Growth, window: Window) -> np.ndarray:
    """Return digits of the rates of growth within the window of each cell, (n, K) float64; NaN where it is empty."""
    found = np.full(growth.path.shape[:2], np.nan)
    for cells, rates in growth.rates(window):
        found[cells] = digits(rates)
    return found


def _uncertified(sweep: Sweep, evidence: Evidence, growth: Growth | None, cells: np.ndarray) -> np.ndarray:
    """Return the region of cells that were integrated to the end, (n,) int8; they are the cells `cells` of `growth`."""
    region = np.full(len(cells), Region.UNDECIDED, np.int8)
    if growth is not None:
        window = averaged(evidence, sweep.clock)
        for kind, found in _kinds(sweep, growth.of(cells), window).items():
            region[found] = kind
        slow = (region == Region.QUASI_PERIODIC) & (evidence["close_steps"] > 0)
        region[slow] = Region.UNDECIDED
    elif sweep.measures.verdict:
        late = late_growth_of(evidence, sweep.clock)
        last = np.full(len(cells), late.path.shape[-1] - 1)
        averages = late.over_last((np.zeros_like(last), last), (1, 2))
        region[np.logical_and(*(chaotic(a, sweep.config.classify) for a in averages))] = Region.CHAOS
    return region


def _kinds(sweep: Sweep, growth: Growth, window: Window) -> dict[Region, np.ndarray]:
    """Return which cells are chaotic, periodic, quasi-periodic by their exponents, (n,) bool each."""
    thresholds = sweep.config.classify
    averages = growth.over_last(window, (2, 4))
    half, quarter = (signs(average, thresholds) for average in averages)
    neutral, negative = half.neutral & quarter.neutral, half.negative & quarter.negative
    enough = neutral.shape[1] >= min(LEAST_EXPONENTS, len(sweep.model.states))
    vanishing = np.where(neutral, _over(vanishing_digits, growth, window), np.inf).min(axis=1)
    regular = (birkhoff_digits(growth, window) >= thresholds.digits) & (vanishing >= thresholds.digits + 1.0)
    told = enough & (neutral | negative).all(axis=1)
    frequencies = neutral.sum(axis=1) + (sweep.model.forcing_period is not None)
    autonomous = sweep.model.forcing_period is None
    return {
        Region.CHAOS: np.logical_and(*(chaotic(average, thresholds) for average in averages)),
        Region.PERIODIC: told & (frequencies == 1) & autonomous & (vanishing >= NO_DRIFT),
        Region.QUASI_PERIODIC: told & (frequencies >= 2) & regular,
    }
