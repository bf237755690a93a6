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

ORBIT = """
name: rossler-maxima
model: rossler
parameters: {a: 0.2, b: 0.2, c: 5.7}
initial: {x: 1, y: 1, z: 1}
integrate: {method: rk4, dt: 0.02, transient: 200, duration: 3000}
measures: {samples: {maxima: x, max: 400}}
"""
PUBLISHED = ((5.88108845586, -2.403953527), (11.7586260717, -3.512006980))  # period, multiplier; by hits 1, 2
PERIOD = 1e-11  # a unit of the last digit, relative to about 10
MULTIPLIER = 1e-9
SOURCE = "ChaosBook"


def cycles(laboratory: Laboratory) -> list[Claim]:
    """Close the cycles of one and two hits."""
    sweep = parse_sweep(ORBIT)
    result = laboratory.run(sweep.name, sweep)
    count = int(result["sample_count"])
    time, state = result["sample_time"][:count], result["samples"][:count]
    search = make_plan(sweep, default_lanes()).search
    parameters, _ = cell_values(sweep, Tile(0, 0, 1))
    return [
        _claim(sweep, search.close(*_nearest(time, state, hits, published[0]), parameters), hits, published)
        for hits, published in enumerate(PUBLISHED, 1)
    ]


def _nearest(time: np.ndarray, state: np.ndarray, hits: int, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the sample that comes back nearest to itself after so many others, and the time that takes."""
    away = np.linalg.norm(state[hits:] - state[:-hits], axis=1)
    near = np.abs(time[hits:] - time[:-hits] - period) < 0.05 * period
    if hits > 1:  # not the shorter cycle, run through more than once
        near &= np.linalg.norm(state[1 : len(away) + 1] - state[: len(away)], axis=1) > 1.0
    i = int(np.argmin(np.where(near, away, np.inf)))
    return state[i : i + 1], time[i + hits : i + hits + 1] - time[i : i + 1]


def _claim(sweep: Sweep, found: Cycles, hits: int, published: tuple[float, float]) -> Claim:
    period, multiplier = float(found.period[0]), complex(found.multipliers[0, 0])
    miss = abs(period - published[0]), abs(multiplier - published[1])
    holds = bool(found.found[0]) and miss[0] <= PERIOD * 10 and miss[1] <= MULTIPLIER
    asked = f"cycle of {hits} maxima: period {published[0]:.12g}, multiplier {published[1]:.10g}, to the last digit"
    measured = f"{period:.12g} (off by {miss[0]:.1e}), {multiplier.real:.10g} (off by {miss[1]:.1e})"
    numbers = {"period": period, "multiplier": multiplier, "hits": hits}
    return Claim(f"{asked} ({SOURCE})", measured, holds, f"guesses from {described(sweep)}", numbers)


ROWS = (Row("published-cycles", "Rössler's unstable cycles", "5 s", cycles),)
