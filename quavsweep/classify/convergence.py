"""How the averages of a cell grow with time."""

from __future__ import annotations

import numpy as np

from quavsweep.classify.growth import growth_of
from quavsweep.classify.window import averaged
from quavsweep.config import Sweep
from quavsweep.measures import Evidence

MOST_TIMES = 512


def convergence(sweep: Sweep, evidence: Evidence) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how averages grow with time.

    Returns
    -------
    until : (n, m) float64
        Times from t = 0, the end of each segment after the transient (of all where a cell ended within it), as far
        as the cell that was integrated longest; evenly thinned out where there are more than 512.
    exponents, errors : (n, m, K) float64
        Averages until then and their standard errors; NaN beyond a cell's end.
    """
    clock, growth = sweep.clock, growth_of(evidence, sweep.clock)
    begin, used = averaged(evidence, clock)
    first = np.where(used > begin, begin, 0)
    most = int((used - first).max(initial=0)) // clock.segment_batches
    chosen = np.unique(np.linspace(1, most, min(most, MOST_TIMES)).round().astype(int))
    n, k = evidence["growth_total"].shape[::2]
    until = np.zeros((n, len(chosen)))
    exponents, errors = np.zeros((n, len(chosen), k)), np.zeros((n, len(chosen), k))
    for number, segments in enumerate(chosen):
        end = first + segments * clock.segment_batches
        average = growth.over((np.where(end > used, used, first), np.minimum(end, used)))
        until[:, number] = np.minimum(end, used) * growth.batch
        exponents[:, number], errors[:, number] = average.rate, average.error
    return until, exponents, errors
