"""Runs across kinks and jumps of the equations: no step crosses one, so a method keeps its order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quavsweep.analysis.event import Event, locate
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.returns import crossed
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program, Ref

MOST = 256  # kinks in a run
STRETCH = 64  # steps after which is seen whether a kink was among them
BESIDE = (
    1e-9  # how far before and behind a kink steps end and begin, in steps: each side is computed by its own equations
)
NUDGE = 1e-6  # step of the differences that give a switch's gradient, against 1 + |u|


def tangent_across(
    flow: Flow,
    method: ButcherTable,
    u: np.ndarray,
    parameters: Sequence[np.ndarray],
    time: np.ndarray,
    steps: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what `Flow.tangent` does, with the steps cut at kinks and jumps, each of which is crossed transversally.

    Where an orbit crosses the surface h = 0 between the velocities f and f', the derivative is multiplied by
    I + (f' - f) grad h^T / (grad h . f), which is I at a kink. Steps are not longer than `time / steps`.

    References
    ----------
    .. [1] P. C. Mueller, Chaos, Solitons and Fractals 5, 1671 (1995).
    """
    n, dimension = u.shape
    events = [_difference(flow.program, left, right) for left, right in flow.program.switches]
    end, left, dt = u.copy(), time.copy(), time / steps
    derivative, volume = np.broadcast_to(np.eye(dimension), (n, dimension, dimension)).copy(), np.zeros(n)
    open_ = np.arange(n)
    for _ in range(MOST):
        if not open_.size:
            break
        own, remaining = [p[open_] for p in parameters], left[open_]
        until, which = _next(flow, method, events, end[open_], own, remaining, dt[open_])
        beside = BESIDE * dt[open_]
        meets = until < remaining - 2.0 * beside
        length = np.where(meets, np.maximum(until - beside, 0.0), remaining)
        counts = _rounded(length / dt[open_])
        x, matrix, growth = flow.tangent(method, end[open_], own, length, counts)
        derivative[open_] = np.matmul(matrix, derivative[open_])
        volume[open_] += growth
        end[open_], left[open_] = x, remaining - length
        open_, which, beside = open_[meets], which[meets], beside[meets]
        if open_.size:
            own = [p[open_] for p in parameters]
            x, _, _ = flow.tangent(method, end[open_], own, 2.0 * beside, np.ones_like(open_))
            jump = _jump(flow, events, which, end[open_], x, own)
            derivative[open_] = np.matmul(jump, derivative[open_])
            volume[open_] += np.log(np.abs(np.linalg.det(jump)))
            end[open_], left[open_] = x, left[open_] - 2.0 * beside
    end[open_] = np.nan
    return end, derivative, volume


def _rounded(steps: np.ndarray) -> np.ndarray:
    """Return the powers of two not below numbers of steps, (n,) int, so that cells share calls of a kernel."""
    return np.asarray(2 ** np.ceil(np.log2(np.maximum(steps, 1.0)) - 1e-9).astype(int))


def _difference(program: Program, left: Ref, right: Ref) -> Event:
    """Return the event that two sides of a comparison are equal."""

    def event(u: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        one, other = program.evaluate([left, right], program.names(u, coefficients))
        return np.broadcast_to(one - other, u.shape[1:])

    return event


def _next(
    flow: Flow,
    method: ButcherTable,
    events: Sequence[Event],
    u: np.ndarray,
    parameters: Sequence[np.ndarray],
    time: np.ndarray,
    dt: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return when orbits next cross a switch, (n,), infinite if they do not, and which it is."""
    until, which = np.full(len(u), np.inf), np.zeros(len(u), dtype=int)
    end, passed, open_, event = u.copy(), 0, np.arange(len(u)), _chosen(events)
    while open_.size:
        own, steps = [p[open_] for p in parameters], dt[open_]
        c = flow.program.coefficient_values(own)
        found = []
        lengths = np.full(open_.size, STRETCH)
        for cells, states in flow.record(method, end[open_], own, STRETCH * steps, lengths):
            end[open_[cells]] = states[-1].T
            for number, one in enumerate(events):
                at, column = crossed(one, "both", states, c[:, cells])
                column, first = np.unique(column, return_index=True)
                at = at[first]
                found.append((cells[column], np.full(column.size, number), at, states[at, :, column]))
        cell, switch, at, begin = (np.concatenate(part) for part in zip(*found, strict=True))
        if cell.size:
            after = flow.steps_from(method, begin, [p[cell] for p in own])
            later, _ = locate(after, steps[cell], event, begin.T.copy(), np.concatenate([c[:, cell], switch[None]]))
            when = later + (passed + at) * steps[cell]
            order = np.lexsort((switch, when, cell))
            soonest = order[np.unique(cell[order], return_index=True)[1]]
            until[open_[cell[soonest]]], which[open_[cell[soonest]]] = when[soonest], switch[soonest]
        passed += STRETCH
        open_ = open_[~np.isfinite(until[open_]) & (passed * steps < time[open_])]
    return until, which


def _chosen(events: Sequence[Event]) -> Event:
    """Return the event that, in each place, is the one whose number comes last among the coefficients."""

    def event(u: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        values = np.array([one(u, coefficients[:-1]) for one in events])
        return np.asarray(values[coefficients[-1].astype(int), np.arange(u.shape[1])])

    return event


def _jump(
    flow: Flow,
    events: Sequence[Event],
    which: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
    parameters: Sequence[np.ndarray],
) -> np.ndarray:
    """Return the derivative across switches, (n, D, D)."""
    dimension = before.shape[1]
    c = flow.program.coefficient_values(parameters)
    gradient = np.zeros_like(before)
    for number, event in enumerate(events):
        cells = np.flatnonzero(which == number)
        for i in range(dimension if cells.size else 0):
            step = NUDGE * (1.0 + np.abs(before[cells, i]))
            shift = np.zeros((dimension, cells.size))
            shift[i] = step
            x = before[cells].T
            gradient[cells, i] = (event(x + shift, c[:, cells]) - event(x - shift, c[:, cells])) / (2.0 * step)
    first, last = flow.velocity(before, parameters), flow.velocity(after, parameters)
    speed = (gradient * first).sum(axis=1)
    return np.asarray(np.eye(dimension) + (last - first)[:, :, None] * gradient[:, None, :] / speed[:, None, None])
