"""Windows of time in whole batches: what was integrated, and what of it is averaged."""

from __future__ import annotations

import numpy as np

from quavsweep.clock import Clock
from quavsweep.codes import Certificate, Status
from quavsweep.measures import Evidence

Window = tuple[np.ndarray, np.ndarray]  # first batch, and that behind the last one, (n,) int each


def used(evidence: Evidence, clock: Clock) -> np.ndarray:
    """Return the batches integrated with finite growth, (n,) int; 0 where the orbit or its frame broke down."""
    bad = np.isin(evidence["status"], (Status.DIVERGED, Status.FRAME_DEGENERATE, Status.NOT_COMPUTED, Status.FAILED))
    return np.where(bad, 0, evidence["steps"] // clock.segment_steps * clock.segment_batches)


def averaged(evidence: Evidence, clock: Clock) -> Window:
    """Return the batches over which exponents are averaged: those after the transient."""
    last = used(evidence, clock)
    return np.full_like(last, clock.transient_segments * clock.segment_batches), last


def ends(evidence: Evidence) -> np.ndarray:
    """Whether it is certified where the orbit ends, (n,) bool."""
    return np.isin(evidence["certificate"], (Certificate.SINK, Certificate.CYCLE))
