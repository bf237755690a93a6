"""Half the step: where an orbit is never chaotic nothing changes, and elsewhere shares do not."""

from __future__ import annotations

import numpy as np

from quavsweep import Result, Sweep
from quavsweep.codes import Certificate
from quavsweep.measures import Evidence
from tests.truth.certificate import certified, same
from tests.truth.laboratory import Laboratory, changed, described
from tests.truth.plane import PLANES, thumbnail
from tests.truth.row import Claim, Row

AGREE = 0.995
TIMES = (1000.0, 2000.0, 4000.0)  # s
ERRORS = 2
GROWN = 10.0  # of ln: an error of a step, 1e-8, becomes one of 2e-4


def half_step(laboratory: Laboratory) -> list[Claim]:
    """Run both thumbnails with the step and with half of it."""
    claims = []
    for name in PLANES:
        sweep, full = thumbnail(laboratory, name)
        clock = sweep.clock
        halves = (f"integrate.dt={clock.dt / 2!r}", f"measures.lyapunov.block={clock.block * 2}")
        half = changed(sweep, *halves)  # orthonormalised, and looked at, at the same times
        result = laboratory.run(f"{name}-half", half)
        setting = f"{described(sweep)}; against dt = {half.clock.dt:g}"
        chaotic = ((full["was_chaotic"] != 0) | (result["was_chaotic"] != 0)).ravel()
        evidence = laboratory.evidence(name, sweep)
        pair = certified(evidence), certified(laboratory.evidence(f"{name}-half", half))
        alike = (full["region"] == result["region"]).ravel()
        alike &= same(*pair) | ((pair[0].kind == Certificate.NONE) & (pair[1].kind == Certificate.NONE))
        share = float(alike[~chaotic].mean())
        measured = f"{share:.2%} of {(~chaotic).sum()} cells; {alike[chaotic].mean():.1%} of the {chaotic.sum()} others"
        numbers = {"share": share, "cells": (~chaotic).sum(), "differ": np.flatnonzero(~alike & ~chaotic)}
        asked = "cells without a chaotic phase: kind and attractor agree in >= 99.5 %"
        claims.append(Claim(asked, measured, share >= AGREE, setting, numbers))
        claims.append(_sensitive(evidence, sweep, chaotic, alike, setting))
        claims += [_settled(full, result, chaotic, time, setting) for time in TIMES]
    return claims


def _sensitive(evidence: Evidence, sweep: Sweep, chaotic: np.ndarray, alike: np.ndarray, setting: str) -> Claim:
    """State by how much tangent vectors of those cells had grown before they settled: how errors grew."""
    segments = evidence["settled_steps"] // sweep.clock.segment_steps
    grown = np.where(np.arange(sweep.clock.segments) < segments[:, None], evidence["growth_total"][:, :, 0], 0.0)
    most = grown.max(axis=1)
    words = []
    for name, which in (("differ", ~alike & ~chaotic), ("agree", alike & ~chaotic)):
        share = np.mean(most[which] > GROWN) if which.any() else 0.0
        words.append(f"of the {which.sum()} that {name} {share:.1%} had grown more, by {np.median(most[which]):.3g}")
    asked = f"growth of ln before they settled, beyond {GROWN:g} or not"
    return Claim(asked, f"{'; '.join(words)} (median)", None, setting, {"grown": most[~alike & ~chaotic]})


def _settled(full: Result, half: Result, chaotic: np.ndarray, time: float, setting: str) -> Claim:
    """Hold shares of settled cells against each other; NaN is later than any time."""
    a, b = (float((result["settle_time"].ravel()[chaotic] <= time).mean()) for result in (full, half))
    n = int(chaotic.sum())
    mean = (a + b) / 2
    error = np.sqrt(max(mean * (1 - mean), 1 / n) * 2 / n)
    asked = f"cells with one: the share settled by {time:g} agrees within 2 binomial errors"
    measured = f"{a:.2%} and {b:.2%} of {n}, {abs(a - b) / error:.2f} errors apart"
    return Claim(asked, measured, abs(a - b) <= ERRORS * error, setting, {"step": a, "half": b, "cells": n})


ROWS = (Row("half-step", "half the step", "30 s", half_step),)
