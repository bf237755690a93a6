"""Answers that would be false: chaos where cycles are, cycles where chaos is, and too many that are undecided."""

from __future__ import annotations

import numpy as np

from quavsweep import Result, Sweep, parse_sweep
from quavsweep.classify import classify
from quavsweep.codes import REGION, Region
from quavsweep.measures import Evidence
from quavsweep.plan import cell_values
from tests.truth.laboratory import Laboratory, described, take, without_certificates
from tests.truth.plane import PLANES, SMALL, plane
from tests.truth.row import Claim, Row
from tests.truth.shooting import Closed, close

FINER = (181, 81)
CYCLES = 1000
UNDECIDED = 0.01
NEUTRAL = 1e-5  # of SciPy's neutral multiplier, to know that it has closed a cycle
SAME_PERIOD = 1e-7  # relative
LORENZ = """
name: lorenz-chaos
model: lorenz
initial: {{x: 1, y: 1, z: 20}}
axes: {{rho: {{values: [{values}]}}}}
integrate: {{method: rk4, dt: 0.005, transient: 200, duration: 4000}}
measures: {{lyapunov: {{exponents: 3, block: 20}}}}
"""


def cycles(laboratory: Laboratory) -> list[Claim]:
    """Close cycles by SciPy, and classify their batches without certificates."""
    wanted = laboratory.choose(CYCLES, 20) // len(PLANES)
    claims = []
    for name in PLANES:
        sweep, result = finer(laboratory, name)
        evidence = laboratory.evidence(f"{name}-finer", sweep)
        cells = np.flatnonzero((result["region"] == Region.PERIODIC).ravel() & np.isfinite(evidence["period"]))
        cells = np.sort(np.random.default_rng(5).permutation(cells)[: wanted + wanted // 5])
        claims += _held(sweep, take(evidence, cells), wanted, described(sweep))
    return claims


def _held(sweep: Sweep, evidence: Evidence, wanted: int, setting: str) -> list[Claim]:
    parameters, _ = cell_values(sweep, evidence["cell"])
    closed = close(sweep.model.rhs, evidence["state"], evidence["period"], parameters)
    sizes, stable = np.abs(closed.multipliers), _stable(closed)
    chosen = np.flatnonzero(stable)[:wanted]
    blind = classify(sweep, without_certificates(sweep, take(evidence, chosen)))["region"]
    chaos = evidence["cell"][chosen][blind == Region.CHAOS]
    counted = _counted(blind)
    numbers = {"cycles": chosen.size, "regions": counted, "chaos": chaos}
    asked = f"{wanted} stable cycles closed by SciPy, their batches without certificates: no chaos"
    measured = f"{stable.sum()} of {stable.size} close; {chosen.size} taken: {_words(counted)}"
    claims = [Claim(asked, measured, chaos.size == 0 and chosen.size == wanted, setting, numbers)]
    ratio = closed.period[chosen] / evidence["period"][chosen]
    own = np.hypot(evidence["multiplier_re"], evidence["multiplier_im"])[chosen]
    miss = np.abs(own - sizes[chosen]).max(initial=0.0)
    worst = np.abs(ratio - 1.0).max(initial=0.0)
    measured = f"periods within {worst:.1e}, sizes of multipliers within {miss:.1e}"
    asked = f"SciPy's periods are the engine's within {SAME_PERIOD:g}"
    numbers = {"period": worst, "multiplier": miss}
    return [*claims, Claim(asked, measured, bool(worst <= SAME_PERIOD), setting, numbers)]


def _stable(closed: Closed) -> np.ndarray:
    """Return which orbits close and are stable, with one neutral multiplier, (n,) bool."""
    neutral = np.abs(closed.multipliers - 1.0).min(axis=1)
    return np.asarray(closed.found & (neutral <= NEUTRAL) & (np.abs(closed.multipliers[:, 0]) <= 1.0 + NEUTRAL))


def lorenz(laboratory: Laboratory) -> list[Claim]:
    """Look for cycles where chaos is all but everywhere; one that SciPy closes and finds stable is no false answer."""
    rho = np.random.default_rng(28).uniform(28.0, 60.0, laboratory.choose(1000, 32))
    text = LORENZ.format(values=", ".join(f"{value:.12g}" for value in np.sort(rho)))
    sweep = parse_sweep(text, changes=laboratory.choose((), ("integrate.duration=1000",)))
    result = laboratory.run(sweep.name, sweep)
    regular = np.flatnonzero(np.isin(result["region"], (Region.PERIODIC, Region.QUASI_PERIODIC)))
    known = regular[np.isfinite(result["period"][regular])]
    parameters, _ = cell_values(sweep, known)
    closed = close(sweep.model.rhs, result["cycle_point"][known], result["period"][known], parameters)
    real = _stable(closed) & (np.abs(closed.period / result["period"][known] - 1.0) <= SAME_PERIOD)
    counted = _counted(result["region"])
    windows = [
        f"at rho {result['rho'][cell]:.9g} SciPy closes a stable cycle of period {period:.9g}, multipliers "
        + ", ".join(f"{abs(value):.4g}" for value in multipliers)
        for cell, period, multipliers in zip(known[real], closed.period[real], closed.multipliers[real], strict=True)
    ]
    false = regular.size - int(real.sum())
    asked = f"Lorenz at {rho.size} rho drawn from [28, 60]: no cycle but real ones in windows"
    numbers = {"regions": counted, "rho": result["rho"][regular], "false": false}
    measured = "; ".join([_words(counted), f"{false} false", *windows])
    return [Claim(asked, measured, false == 0, described(sweep), numbers)]


def undecided(laboratory: Laboratory) -> list[Claim]:
    """Count undecided cells of both planes, whole: a sample could not tell 0.9 % from 1.1 %."""
    claims = []
    for name in PLANES:
        sweep = plane(name, laboratory.choose(None, SMALL))
        result = laboratory.run(f"{name}-whole", sweep)
        share = float((result["region"] == Region.UNDECIDED).mean())
        counted = _counted(result["region"])
        numbers = {"share": share, "regions": counted, "cells": np.flatnonzero(result["region"] == Region.UNDECIDED)}
        asked = f"{name}: at most 1 % undecided at 4,000 s without effort"
        claims.append(Claim(asked, f"{share:.3%}: {_words(counted)}", share <= UNDECIDED, described(sweep), numbers))
    return claims


def finer(laboratory: Laboratory, name: str) -> tuple[Sweep, Result]:
    """Return a plane on a finer grid, to the end of all cells."""
    sweep = plane(name, laboratory.choose(FINER, SMALL), "stop_early=false")
    return sweep, laboratory.run(f"{name}-finer", sweep)


def _counted(region: np.ndarray) -> dict[str, int]:
    count = np.bincount(region.ravel(), minlength=len(REGION))
    return {code.name: int(n) for code, n in zip(REGION, count, strict=True) if n}


def _words(counted: dict[str, int]) -> str:
    return ", ".join(f"{n} {name}" for name, n in counted.items())


ROWS = (
    Row("false-chaos", "cycles, closed by SciPy, classified without certificates", "3 min", cycles),
    Row("false-cycles", "Lorenz' chaos", "10 s", lorenz),
    Row("undecided", "undecided cells of both planes", "2 min", undecided),
)
