"""Passes: cells whose end is not known at that of a sweep go on, each pass twice as long, from their checkpoints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from quavsweep.classify import unsettled
from quavsweep.codes import Status
from quavsweep.config import Sweep
from quavsweep.measures import Evidence

GoOn = Callable[[int, int, Evidence], Evidence | None]  # from an end to the next: evidence of cells to theirs there


def with_passes(sweep: Sweep, evidence: Evidence, go_on: GoOn) -> tuple[Evidence, int]:
    """Return evidence with what the passes of the effort added, and how many cells wait for a pass.

    Which cells go through a pass follows from the evidence at the end of the one before and the thresholds alone.

    Parameters
    ----------
    sweep : Sweep
    evidence : dict of arrays
        Of some cells at the end of the sweep.
    go_on : callable
        Gives the evidence of cells at a later end, or None if it is not there.
    """
    begin = sweep.clock.steps
    for end in sweep.pass_ends():
        going = (evidence["status"] == Status.TIME_OVER) & (evidence["steps"] == begin)
        rows = (
            np.flatnonzero(going & unsettled(sweep.until(begin), evidence)) if going.any() else np.zeros(0, dtype=int)
        )
        if not rows.size:
            break
        longer = go_on(begin, end, {name: values[rows] for name, values in evidence.items()})
        if longer is None:
            return evidence, rows.size
        evidence = _merged(sweep.until(end), evidence, rows, longer)
        begin = end
    return evidence, 0


def _merged(sweep: Sweep, evidence: Evidence, rows: np.ndarray, longer: Evidence) -> Evidence:
    """Return evidence in which some cells have gone on; the others have nothing there.

    What goes into the result as it is keeps its shape: an orbit is recorded up to the end of the sweep.
    """
    merged, kept = {}, {variable.name for variable in sweep.measures.outputs}
    for variable in sweep.measures.evidence:
        values, added = evidence[variable.name], longer[variable.name]
        if variable.name in kept:
            wide, added = values.copy(), added[(slice(None), *(slice(0, length) for length in values.shape[1:]))]
        else:
            wide = variable.empty(len(values), sweep.extents)
            wide[tuple(slice(0, length) for length in values.shape)] = values
        wide[rows] = added
        merged[variable.name] = wide
    return merged
