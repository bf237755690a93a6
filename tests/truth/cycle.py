"""Exponents of certified cycles: neutral along the flow, and elsewhere those of a long average."""

from __future__ import annotations

import numpy as np

from quavsweep.classify import classify
from quavsweep.codes import Certificate
from tests.truth.laboratory import Laboratory, described, take, without_certificates
from tests.truth.plane import LONGER, PLANES, long_thumbnail, thumbnail
from tests.truth.row import Claim, Row

ZERO = 1e-8  # 1/s
ERRORS = 3
BOUNDED = 3  # departures of the growth of ln from its straight line by which a regular average may be off, over T


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
        claims.append(_averaged(laboratory, name, cycle, exact))
    return claims


def _averaged(laboratory: Laboratory, name: str, cycle: np.ndarray, exact: np.ndarray) -> Claim:
    """Hold the other exponents against averages of cells that were certified before the averages begin."""
    sweep, _ = long_thumbnail(laboratory, name)
    evidence = laboratory.evidence(f"{name}-long", sweep)
    early = evidence["certified_steps"] <= sweep.clock.transient_steps
    cells = np.flatnonzero(cycle & early & (evidence["certificate"] == Certificate.CYCLE))
    blind = classify(sweep, without_certificates(sweep, take(evidence, cells)))
    raw, error = blind["lyapunov"][:, 1:], blind["lyapunov_se"][:, 1:]
    departure = blind["growth_departure"][:, 1:] if "growth_departure" in blind else np.ones_like(raw)
    allowed = np.maximum(ERRORS * error, BOUNDED * departure / sweep.clock.duration)
    miss = np.abs(raw - exact[cells, 1:])
    over = ~(miss <= allowed).all(axis=1)
    share = (miss / allowed).max(initial=0.0)
    asked = f"the others equal the long average within max({ERRORS} errors, {BOUNDED} F / T)"
    measured = f"{(~over).sum()} of {cells.size}, off by {miss.max(initial=0.0):.1e} at most, {share:.2f} of what is "
    measured += "allowed"
    numbers = {"cells": cells.size, "over": cells[over], "worst": miss.max(initial=0.0), "share": share}
    setting = f"{described(sweep)}; {LONGER} times as long"
    return Claim(asked, measured, not over.any() and cells.size > 0, setting, numbers)


ROWS = (Row("cycles", "exponents of certified cycles", "2 min, shared with certificates-final", exponents),)
