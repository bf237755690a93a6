"""What a shard holds of each cell: all its evidence, or at once what the classification makes of it.

The classification is loaded only where it is needed: looking at a folder that keeps evidence does without.
"""

from __future__ import annotations

import math

import numpy as np

from quavsweep.codes import REGION
from quavsweep.config import Sweep
from quavsweep.measures import BASE, Evidence, Variable

CELL = BASE[0]  # the number of the cell, which is no variable of the result


def content_variables(sweep: Sweep) -> tuple[Variable, ...]:
    """Return what a shard of a sweep holds of each cell."""
    if sweep.keeps_evidence:
        return sweep.measures.evidence
    from quavsweep.classify import result_variables

    return (CELL, *result_variables(sweep))


def content_bytes(sweep: Sweep) -> int:
    """Return the size of a cell in a shard."""
    shapes = ((v.dtype, v.shape(1, sweep.extents)) for v in content_variables(sweep))
    return sum(np.dtype(dtype).itemsize * math.prod(shape) for dtype, shape in shapes)


def content_of(sweep: Sweep, evidence: Evidence) -> dict[str, np.ndarray]:
    """Return what a shard holds of cells with this evidence."""
    if sweep.keeps_evidence:
        return evidence
    from quavsweep.classify import classify

    return {CELL.name: evidence[CELL.name], **classify(sweep, evidence)}


def region_counts(sweep: Sweep, content: dict[str, np.ndarray]) -> np.ndarray:
    """Return how many cells of a shard's content are in each region, (regions,) int."""
    from quavsweep.classify import regions

    region = regions(sweep, content) if sweep.keeps_evidence else content["region"]
    return np.bincount(region, minlength=len(REGION))
