"""Tubes around the cycles of the sweep's method itself, where those of the flow are too far from its orbits.

The cycle of a method of low order lies beside that of the flow. Where the return map bends strongly, as on long cycles
of the Lorenz system, that distance can be wider than the neighbourhood in which the map contracts. Then the cycle of
the method is closed by Newton's method too, in the whole number of steps nearest to its period, and the tube is laid
around it.

A period is no whole number of the sweep's steps, so its orbit still does not come back exactly. By how much is seen on
the orbit: of its hits with the sweep's own step, three must lie near the cycle's point, and if the farthest of these
is at the distance d, a return misses by at most (1 + q) d, q as in `quavsweep.analysis.tube`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quavsweep.analysis.event import Event, locate
from quavsweep.analysis.returns import crossed
from quavsweep.analysis.shooting import Closed, Shooting, grade
from quavsweep.analysis.tube import FLOOR, ROOM, UNIT, ReturnMap, frame_around
from quavsweep.kernels.method import ButcherTable

RETURNS = 3  # of the orbit to the cycle's point
PERIODS = RETURNS + 0.5  # in which they are looked for
LEAST_STEPS = 8  # of a period


def examine_own_cycle(
    shooting: Shooting,
    method: ButcherTable,
    dt: float,
    closed: Closed,
    amplitude: np.ndarray,
    parameters: Sequence[np.ndarray],
    start: np.ndarray,
    direction: str,
) -> np.ndarray:
    """Say which orbits of an autonomous system without kinks are inside the tubes of their method's cycles, (n,) bool.

    Parameters
    ----------
    shooting : Shooting
    method, dt
        Those of the sweep.
    closed : Closed
        n cycles of the flow.
    amplitude : (n, D) float64
    start : (n, D) float64
        States on the orbits.
    direction : str
        In which the section is crossed.
    """
    inside = np.zeros(len(closed.found), dtype=bool)
    good = np.flatnonzero(closed.found)
    event, flow = shooting.event, shooting.flow
    if event is None or flow.program.switches or not good.size:
        return inside
    steps = np.maximum(np.rint(closed.period[good] / dt).astype(int), LEAST_STEPS)
    own = shooting.close_as(method, closed.take(good), [p[good] for p in parameters], amplitude[good], steps)
    slowest = _slowest(own)
    kept = np.flatnonzero(own.found & (np.abs(slowest) < UNIT))
    if not kept.size:
        return inside
    good, own, slowest, steps = good[kept], own.take(kept), slowest[kept], steps[kept]
    given = [p[good] for p in parameters]
    frame = frame_around(own, np.abs(slowest), amplitude[good], shooting.circle, forced=False)
    turns = np.where(slowest.real < 0, 2, 1)
    returns = ReturnMap(flow, method, own, given, frame, turns, turns * steps)
    _, norm_ = returns.images(own.point)
    cells, hits = _hits(shooting, method, dt, event, direction, start[good], own.period, given)
    distance = frame.take(cells).distance(hits)
    order = np.lexsort((distance, cells))
    rank = np.arange(cells.size) - np.searchsorted(cells[order], cells[order])
    farthest = np.full(good.size, np.inf)
    third = order[rank == RETURNS - 1]
    farthest[cells[third]] = distance[third]
    missed = (1.0 + norm_) * farthest
    radius = np.maximum(ROOM * farthest, FLOOR * missed / (1.0 - norm_))
    inside[good] = returns.contracts(np.isfinite(radius), radius, missed, norm_)[0]
    return inside


def _slowest(closed: Closed) -> np.ndarray:
    """Return the multiplier of largest size but the neutral one, (n,) complex128, of those that close."""
    values = np.linalg.eigvals(np.where(closed.found[:, None, None], closed.derivative, 0.0)).astype(complex)
    rows = np.arange(len(values))
    values[rows, np.argmin(np.abs(values - 1.0), axis=1)] = 0.0
    return np.asarray(values[rows, np.argmax(np.abs(values), axis=1)])


def _hits(
    shooting: Shooting,
    method: ButcherTable,
    dt: float,
    event: Event,
    direction: str,
    start: np.ndarray,
    period: np.ndarray,
    parameters: Sequence[np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Return cells, (k,), and hits, (k, D), of orbits that are followed with the sweep's step for `PERIODS`."""
    flow = shooting.flow
    c, steps = flow.program.coefficient_values(parameters), grade(PERIODS * period / dt)
    found = []
    for cells, states in flow.record(method, start, parameters, steps * dt, steps):
        at, column = crossed(event, direction, states, c[:, cells])
        found.append((cells[column], states[at, :, column]))
    cells, begin = (np.concatenate(part) for part in zip(*found, strict=True))
    if not cells.size:
        return cells, begin
    after = flow.steps_from(method, begin, [p[cells] for p in parameters])
    return cells, locate(after, dt, event, np.ascontiguousarray(begin.T), c[:, cells])[1].T
