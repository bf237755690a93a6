"""Certificates are final: after ten times the time every certified cell is still where it was said to end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quavsweep import Result, Sweep
from quavsweep.analysis.certificate import examine
from quavsweep.codes import Certificate
from quavsweep.kernels.compiler import default_lanes
from quavsweep.measures import Evidence
from quavsweep.plan import cell_values, make_plan
from tests.truth.laboratory import Laboratory, described, take
from tests.truth.plane import LONGER, PLANES, long_thumbnail, thumbnail
from tests.truth.row import Claim, Row

NEAR = 1e-6  # of equilibria and points of cycles, against 1 + |u|
PERIOD = 1e-8  # relative
LOOKED_AT = 4  # segments that a search for cycles may follow


@dataclass(frozen=True)
class Attractor:
    """What n states lead to: a kind, a point, and of cycles period, hits and symmetry; NaN and 0 where unknown."""

    kind: np.ndarray
    point: np.ndarray
    period: np.ndarray
    hits: np.ndarray
    symmetry: np.ndarray


def found_anew(sweep: Sweep, cells: np.ndarray, u: np.ndarray) -> Attractor:
    """Return what states lead to, by a new search that knows of nothing else.

    Parameters
    ----------
    sweep : Sweep
    cells : (n,) int
        Cells of its grid, for their parameters.
    u : (n, D) float64
    """
    plan = make_plan(sweep, default_lanes())
    parameters, _ = cell_values(sweep, cells)
    coefficients = plan.program.coefficient_values(parameters)
    ends = examine(plan.program, plan.method, plan.clock.dt, u, coefficients)
    cycles = plan.search.find(u, parameters, LOOKED_AT * plan.clock.segment_steps)
    closed = cycles.found & ~cycles.resting & ~ends.inside
    kind = np.where(ends.inside, Certificate.SINK, np.where(closed, Certificate.CYCLE, Certificate.NONE))
    point = np.where(closed[:, None], cycles.point, ends.equilibrium)
    return Attractor(kind, point, cycles.period, cycles.hits, cycles.symmetry)


def certified(evidence: Evidence) -> Attractor:
    """Return what evidence says."""
    cycle = (evidence["certificate"] == Certificate.CYCLE)[:, None]
    point = np.where(cycle, evidence["cycle_point"], evidence["equilibrium"])
    known = (evidence[name] for name in ("period", "cycle_hits", "cycle_symmetry"))
    return Attractor(evidence["certificate"], point, *known)


def same(a: Attractor, b: Attractor) -> np.ndarray:
    """Return which attractors are the same, (n,) bool."""
    size = 1.0 + np.linalg.norm(a.point, axis=1)
    near = (a.kind == b.kind) & (np.linalg.norm(a.point - b.point, axis=1) <= NEAR * size)
    cycle = np.abs(a.period - b.period) <= PERIOD * a.period
    cycle &= (a.hits == b.hits) & (a.symmetry == b.symmetry)
    return np.asarray(near & (cycle | (a.kind == Certificate.SINK)))


def final(laboratory: Laboratory) -> list[Claim]:
    """Look for the attractors of certified cells anew, from states after ten times the time."""
    claims = []
    for name in PLANES:
        short, _ = thumbnail(laboratory, name)
        long, result = long_thumbnail(laboratory, name)
        evidence = laboratory.evidence(name, short)
        claims += _held(short, long, evidence, result)
    return claims


def _held(short: Sweep, long: Sweep, evidence: Evidence, result: Result) -> list[Claim]:
    u = result["final_state"].reshape(-1, len(short.model.states))
    setting = f"{described(short)}; against T = {LONGER} times as long without early ends, searched anew at its end"
    claims = []
    for kind, name in ((Certificate.SINK, "sink"), (Certificate.CYCLE, "cycle")):
        cells = np.flatnonzero(evidence["certificate"] == kind)
        first, last = certified(take(evidence, cells)), found_anew(long, cells, u[cells])
        agree = same(first, last)
        away = np.linalg.norm(first.point - last.point, axis=1)[agree].max(initial=0.0)
        measured = f"{agree.sum()} of {cells.size}, points within {away:.1e}"
        if not agree.all():
            others = np.bincount(last.kind[~agree], minlength=len(Certificate))
            words = ", ".join(f"{n} {Certificate(i).name.lower()}" for i, n in enumerate(others) if n)
            measured += f"; of the others the search finds {words}; the first is cell {cells[~agree][0]}"
        numbers = {"certified": cells.size, "same": agree.sum(), "away": away, "others": cells[~agree]}
        asked = f"every certified {name} ends in the same attractor"
        claims.append(Claim(asked, measured, bool(agree.all()), setting, numbers))
    return claims


ROWS = (Row("certificates-final", "certificates against ten times the time", "2 min", final),)
