"""Rössler's unstable cycles: returns of a chaotic orbit, closed by the engine's shooting, against published digits."""

from __future__ import annotations

import numpy as np

from quavsweep import Sweep, parse_sweep
from quavsweep.analysis.cycle import Cycles
from quavsweep.grid import Tile
from quavsweep.kernels.compiler import default_lanes
from quavsweep.plan import cell_values, make_plan
from tests.truth.laboratory import Laboratory, described
from tests.truth.row import Claim, Row
from tests.truth.shooting import Closed, close

ORBIT = """
name: rossler-maxima
model: rossler
parameters: {a: 0.2, b: 0.2, c: 5.7}
initial: {x: 1, y: 1, z: 1}
integrate: {method: rk4, dt: 0.02, transient: 200, duration: 3000}
measures: {samples: {maxima: x, max: 400}}
"""
PUBLISHED = ((5.88108845586, -2.403953527), (11.7586260717, -3.512006980))  # period, multiplier; by hits 1, 2
PERIOD, MULTIPLIER = 1e-9, 1e-8  # of the published digits; SciPy's shooting finds the last ones of a period otherwise
TWIN = 1e-9  # of SciPy's period and multiplier
TOLERANCE = 1e-13  # of SciPy
SOURCE = "ChaosBook"


def cycles(laboratory: Laboratory) -> list[Claim]:
    """Close the cycles of one and two hits."""
    sweep = parse_sweep(ORBIT)
    result = laboratory.run(sweep.name, sweep)
    count = int(result["sample_count"])
    time, state = result["sample_time"][:count], result["samples"][:count]
    search = make_plan(sweep, default_lanes()).search
    parameters, _ = cell_values(sweep, Tile(0, 0, 1))
    claims = []
    for hits, published in enumerate(PUBLISHED, 1):
        guess = _nearest(time, state, hits, published[0])
        own = search.close(*guess, parameters)
        twin = close(sweep.model.rhs, *guess, parameters, TOLERANCE)
        claims.append(_claim(sweep, own, twin, hits, published))
    return claims


def _nearest(time: np.ndarray, state: np.ndarray, hits: int, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the sample that comes back nearest to itself after so many others, and the time that takes."""
    away = np.linalg.norm(state[hits:] - state[:-hits], axis=1)
    near = np.abs(time[hits:] - time[:-hits] - period) < 0.05 * period
    if hits > 1:  # not the shorter cycle, run through more than once
        near &= np.linalg.norm(state[1 : len(away) + 1] - state[: len(away)], axis=1) > 1.0
    i = int(np.argmin(np.where(near, away, np.inf)))
    return state[i : i + 1], time[i + hits : i + hits + 1] - time[i : i + 1]


def _claim(sweep: Sweep, own: Cycles, twin: Closed, hits: int, published: tuple[float, float]) -> Claim:
    """Hold a cycle against the published one, and against SciPy's."""
    period, multiplier = float(own.period[0]), complex(own.multipliers[0, 0])
    miss = abs(period - published[0]), abs(multiplier - published[1])
    apart = abs(period - float(twin.period[0])), abs(multiplier - complex(twin.multipliers[0, 0]))
    holds = bool(own.found[0]) and int(own.hits[0]) == hits and miss[0] <= PERIOD and miss[1] <= MULTIPLIER
    asked = f"cycle of {hits} maxima: period {published[0]:.12g} within {PERIOD:g}, "
    asked += f"multiplier {published[1]:.10g} within {MULTIPLIER:g} ({SOURCE}); SciPy's shooting within {TWIN:g}"
    measured = f"{period:.13g}, off by {miss[0]:.1e}; {multiplier.real:.11g}, off by {miss[1]:.1e}; from SciPy's at "
    measured += (
        f"{TOLERANCE:g} ({twin.period[0]:.13g}, {twin.multipliers[0, 0].real:.11g}) {apart[0]:.1e}, {apart[1]:.1e}"
    )
    numbers = {"period": period, "multiplier": multiplier, "scipy": [twin.period[0], twin.multipliers[0, 0]]}
    holds = holds and max(apart) <= TWIN
    return Claim(asked, measured, holds, f"guesses from {described(sweep)}", numbers)


ROWS = (Row("published-cycles", "Rössler's unstable cycles", "5 s", cycles),)
