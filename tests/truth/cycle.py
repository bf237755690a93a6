"""Exponents of certified cycles: neutral along the flow, and elsewhere those of a long average."""

from __future__ import annotations

import numpy as np

from quavsweep.classify import classify
from quavsweep.codes import Certificate
from quavsweep.measures import Evidence
from quavsweep.plan import cell_values
from tests.truth.laboratory import Laboratory, described, take, without_certificates
from tests.truth.plane import LONGER, PLANES, long_thumbnail, thumbnail
from tests.truth.row import Claim, Row
from tests.truth.shooting import unevenness

ZERO = 1e-8  # 1/s
ERRORS = 3
DEPARTURES = 3  # F, the departure of the growth of ln from its straight line as far as batches show it
RANGES = 2  # of ln of the speed along the cycle: growth along the flow departs by one, in other directions by as much


def exponents(laboratory: Laboratory) -> list[Claim]:
    """Hold the exponents of cycles on both thumbnails against averages over ten times the time."""
    claims = []
    for name in PLANES:
        sweep, result = thumbnail(laboratory, name)
        evidence = laboratory.evidence(name, sweep)
        cycle = evidence["certificate"] == Certificate.CYCLE
        exact = result["lyapunov"].reshape(evidence["cell"].size, -1)
        neutral = np.abs(exact[cycle, 0])
        worst = neutral.max(initial=0.0)
        asked = f"the largest exponent of each certified cycle is 0 to {ZERO:g}"
        measured = f"{worst:.1e} at most of {cycle.sum()}, computed; {(neutral == 0).sum()} are 0 exactly"
        numbers = {"worst": worst, "cycles": cycle.sum()}
        claims.append(Claim(asked, measured, bool(worst <= ZERO) and bool(cycle.any()), described(sweep), numbers))
        claims += _averaged(laboratory, name, evidence, exact)
    return claims


def _averaged(laboratory: Laboratory, name: str, evidence: Evidence, exact: np.ndarray) -> list[Claim]:
    """Hold the other exponents against averages of cells that were certified before the averages begin."""
    sweep, _ = long_thumbnail(laboratory, name)
    long = laboratory.evidence(f"{name}-long", sweep)
    early = long["certified_steps"] <= sweep.clock.transient_steps
    cells = np.flatnonzero(early & (evidence["certificate"] == long["certificate"]) & (long["period"] > 0))
    blind = classify(sweep, without_certificates(sweep, take(long, cells)))
    time = sweep.clock.duration
    miss = np.abs(blind["lyapunov"] - exact[cells])[:, 1:]
    parameters, _ = cell_values(sweep, cells)
    uneven = unevenness(sweep.model.rhs, evidence["cycle_point"][cells], evidence["period"][cells], parameters)
    statistical = ERRORS * blind["lyapunov_se"][:, 1:]
    known = np.maximum(statistical, RANGES * uneven[:, None] / time)
    own = np.maximum(statistical, DEPARTURES * blind["growth_departure"][:, 1:] / time)
    setting = f"{described(sweep)}; {LONGER} times as long"
    over, share = ~(miss <= known).all(axis=1), float((miss / known).max(initial=0.0))
    measured = f"{(~over).sum()} of {cells.size}, off by {miss.max(initial=0.0):.1e} at most, {share:.2f} of that; "
    measured += f"R is {uneven.min(initial=np.inf):.2f} to {uneven.max(initial=0.0):.2f}"
    asked = f"the others equal the long average within max({ERRORS} errors, {RANGES} R / T), R the range of ln |du/dt|"
    numbers = {"cells": cells.size, "over": cells[over], "worst": miss.max(initial=0.0), "share": share}
    claim = Claim(asked, measured, not over.any() and cells.size > 0, setting, numbers)
    over = ~(miss <= own).all(axis=1)
    measured = f"{(~over).sum()} of {cells.size}, {(miss / own).max(initial=0.0):.3g} of that at most"
    asked = f"and within what batches alone tell, max({ERRORS} errors, {DEPARTURES} F / T)"
    return [claim, Claim(asked, measured, None, setting, {"over": cells[over]})]


ROWS = (Row("cycles", "exponents of certified cycles", "2 min, shared with certificates-final", exponents),)
