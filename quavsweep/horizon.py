"""What a shorter run would have left: evidence cut off at a time, without integrating again."""

from __future__ import annotations

import numpy as np

from quavsweep.codes import Certificate, Status
from quavsweep.config import Sweep
from quavsweep.errors import ConfigError
from quavsweep.measures import Evidence, Variable

_BATCH, _SEGMENT = "batch", "segment"
_SINK = ("equilibrium", "eigenvalue_re", "eigenvalue_im")
_CYCLE = ("period", "cycle_hits", "cycle_symmetry", "cycle_point", "multiplier_re", "multiplier_im")
_UNKNOWN = ("state", "frame", "late_growth")  # of cells that went on, they are those of a later time


def truncated(sweep: Sweep, evidence: Evidence, steps: int) -> Evidence:
    """Return the evidence that a run with the same batches would have left, had it ended after so many steps.

    Parameters
    ----------
    sweep : Sweep
    evidence : dict of (n, ...) arrays
        As long as it may be; none of them is changed.
    steps : int
        Whole segments, at least one beyond the transient.

    Returns
    -------
    dict of (n, ...) arrays
        Of the same shapes, NaN beyond the end. Region, exponents and errors follow from it as from a real run. States
        of cells that went on are unknown, NaN; what other measures recorded is left as it is.

    Raises
    ------
    ConfigError
        If a run cannot end there.
    """
    clock = sweep.clock
    if steps % clock.segment_steps or steps <= clock.transient_steps:
        length = clock.segment_steps * clock.dt
        what = f"a run cannot end after {steps * clock.dt:g}"
        raise ConfigError(what, possible=f"whole segments of {length:g} beyond the transient, {clock.transient:g}")
    variables = {v.name: v for v in sweep.measures.evidence}
    cut = {name: values.copy() for name, values in evidence.items()}
    went_on = evidence["steps"] > steps
    degenerate = _degenerate(evidence, steps // clock.segment_steps - 1)
    cut["steps"][went_on] = steps
    cut["status"][went_on] = np.where(degenerate[went_on], Status.FRAME_DEGENERATE, Status.TIME_OVER)
    for name in _UNKNOWN:
        if name in cut:
            cut[name][went_on] = np.nan
    for name, values in cut.items():
        if variables[name].dims[:1] == (_BATCH,):
            values[:, steps // clock.batch_steps :] = np.nan
        elif variables[name].dims[:1] == (_SEGMENT,):
            values[:, steps // clock.segment_steps :] = np.nan
    _forget_later(cut, variables, steps)
    return cut


def _degenerate(evidence: Evidence, segment: int) -> np.ndarray:
    """Whether the tangent frame had lost rank by the end of a segment, (n,) bool: it voids the growth."""
    lost = evidence["status"] == Status.FRAME_DEGENERATE
    if "growth_total" not in evidence or not evidence["growth_total"].shape[2]:
        return np.zeros_like(lost)
    return np.asarray(lost & np.isnan(evidence["growth_total"][:, segment, 0]))


def _forget_later(cut: Evidence, variables: dict[str, Variable], steps: int) -> None:
    """Take away what was certified later; an orbit that rested by then still rests."""
    certificate = cut["certificate"]
    later = (certificate != Certificate.NONE) & (cut["certified_steps"] > steps)
    rests = (cut["rest_steps"] > 0) & (cut["rest_steps"] <= steps)
    later |= (certificate == Certificate.REST) & ~rests
    was_sink = certificate != Certificate.CYCLE
    certificate[later] = np.where(rests & was_sink, Certificate.REST, Certificate.NONE)[later]
    for name in ("certified_steps", "settled_steps"):
        cut[name][later] = 0
    cut["rest_steps"][~rests] = 0
    cut["close_steps"][cut["close_steps"] > steps] = 0
    for name in _SINK:
        cut[name][later & ~(rests & was_sink)] = variables[name].fill
    for name in _CYCLE:
        cut[name][later] = variables[name].fill
