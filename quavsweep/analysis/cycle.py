"""Cycles certified: found by returns to the section, closed by shooting, stable, and with the orbit in their tube."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from quavsweep.analysis.event import Event, locate, step
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.returns import (
    MOST_HITS,
    ROUNDING,
    Hits,
    amplitudes,
    between,
    circles,
    collect,
    crossed,
    nearest_return,
    section_of,
    shortest,
    size,
)
from quavsweep.analysis.shooting import METHOD, Closed, Shooting, floquet, grade
from quavsweep.analysis.tube import UNIT, examine_tube
from quavsweep.clock import Clock
from quavsweep.codes import CycleSymmetry
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program
from quavsweep.models import Model

RATIO = 4  # steps of a method of low order that one of order 8 takes at once where that need not be exact
ATTEMPTS = 3  # guesses of the period: the first, its divisor or double, and once more
SPARSE = 4  # steps of a stretch of which one is enough to see how far an orbit goes
SAME = 1e-6  # distance in amplitudes below which two exact hits are one
SHRUNK = 0.1  # a closed orbit smaller than this share of the recorded one is an equilibrium's spiral
REST = 1e-8  # amplitude against 1 + |u| of a forced orbit that rests
REST_SCALE = 1e-2  # unit of length around such a rest, against 1 + |u|


@dataclass(frozen=True)
class Cycles:
    """What is known of the cycles of n orbits; NaN and 0 where none is found.

    Parameters
    ----------
    found : (n,) bool
        From `find`: the orbit is in the tube of a stable cycle. From `close`: an orbit closes here.
    resting : (n,) bool
        The cycle of a forced system is a state that does not move, so a sink.
    period : (n,) float64
        The least one [time unit of the model].
    hits : (n,) int
        Hits of the section per period; forced systems: periods of the forcing.
    symmetry : (n,) int8
        Codes of `CycleSymmetry`.
    point : (n, D) float64
        Of the hits, the one that comes last in the order of the states: with the largest first state, of those the one
        with the largest second state, and so on; values count as equal up to 1e-9 of the amplitude. Runs into one
        cycle give one point up to about that, and mirror images give two.
    multipliers : (n, D) complex128
        Floquet multipliers, largest size first; with the neutral one in autonomous systems, as computed.
    exponents : (n, D) float64
        ln |multiplier| / period, largest first.
    """

    found: np.ndarray
    resting: np.ndarray
    period: np.ndarray
    hits: np.ndarray
    symmetry: np.ndarray
    point: np.ndarray
    multipliers: np.ndarray
    exponents: np.ndarray

    @classmethod
    def none(cls, n: int, dimension: int) -> Cycles:
        """Return n orbits without a cycle."""
        return cls(
            np.zeros(n, dtype=bool),
            np.zeros(n, dtype=bool),
            np.full(n, np.nan),
            np.zeros(n, dtype=int),
            np.zeros(n, dtype=np.int8),
            np.full((n, dimension), np.nan),
            np.full((n, dimension), complex(np.nan, np.nan)),
            np.full((n, dimension), np.nan),
        )

    def put(self, cells: np.ndarray, other: Cycles, which: np.ndarray) -> None:
        """Write some of other cycles, (m,) bool, into those of these cells, (m,) int."""
        for field in fields(self):
            getattr(self, field.name)[cells[which]] = getattr(other, field.name)[which]


@dataclass(frozen=True)
class _Tour:
    """One period of n closed orbits: exact hits, amplitudes, and whether their mirror images are the same orbit."""

    hits: Hits
    amplitude: np.ndarray
    symmetry: np.ndarray


class CycleSearch:
    """Looks for the cycles on which orbits of a model end.

    Cheap to make; kernels are compiled when first needed. What it says of a cell does not depend on the other cells.

    Parameters
    ----------
    model : Model
    program : Program
    method : ButcherTable
        Of the sweep.
    clock : Clock
    lanes : int
        Cells per group of the kernels.
    """

    def __init__(self, model: Model, program: Program, method: ButcherTable, clock: Clock, lanes: int) -> None:
        self._model, self._program, self._method, self._dt = model, program, method, clock.dt
        self._flow = Flow(program, lanes)
        self._step = self._dt * (1 if method.order >= METHOD.order else RATIO)
        self._event, self._direction = section_of(model, program)
        self._circle = circles(model)
        self._signs = [np.array(s, dtype=float) for s in model.symmetries if any(sign != 1 for sign in s)]
        section = model.section
        self._shooting = Shooting(
            self._flow,
            self._circle,
            None if self._forced else self._event,
            model.state_names.index(section.of) if section else 0,
            section is None or section.at is None,
            self._step if self._step > self._dt else 2.0 * self._dt,
        )

    @property
    def _forced(self) -> bool:
        return self._model.forcing_period is not None

    def find(self, u: np.ndarray, parameters: Sequence[np.ndarray], steps: int) -> Cycles:
        """Return the stable cycles in whose tubes orbits are.

        Parameters
        ----------
        u : (n, D) float64
            States; of forced systems at phase 0.
        parameters : sequence of (n,) arrays
            In the model's order.
        steps : int
            Steps of the sweep that may be followed from here on. A cycle is found if two of its periods fit in.
        """
        cycles = Cycles.none(*u.shape)
        with np.errstate(all="ignore"):
            hits, amplitude = self._stretch(u, parameters, steps)
            count = nearest_return(hits, amplitude, self._circle)
            for _ in range(ATTEMPTS):
                open_ = np.flatnonzero(count)
                if not open_.size:
                    break
                some = Hits(hits.count[open_], hits.time[open_], hits.state[open_])
                found, again = self._attempt(some, amplitude[open_], [p[open_] for p in parameters], count[open_])
                cycles.put(open_, found, found.found)
                count[open_] = again
        return cycles

    def close(self, u: np.ndarray, period: np.ndarray, parameters: Sequence[np.ndarray]) -> Cycles:
        """Return the cycles, stable or not, that Newton's method reaches from guesses of a point and the period.

        Parameters
        ----------
        u : (n, D) float64
            Points near the section.
        period : (n,) float64
        parameters : sequence of (n,) arrays
        """
        with np.errstate(all="ignore"):
            multiple = np.ones(len(u), dtype=int)
            if self._forced:
                multiple = np.maximum(np.rint(period / self._forcing(parameters)).astype(int), 1)
            amplitude = np.empty_like(u)
            steps = grade(period / self._step)
            for cells, states in self._flow.record(METHOD, u, parameters, period, steps):
                amplitude[cells] = amplitudes(states, self._circle)
            closed = self._shooting.close(u, period, parameters, amplitude, multiple)
            return self._describe(closed, self._tour(closed, parameters, multiple), *floquet(closed))

    def _stretch(self, u: np.ndarray, parameters: Sequence[np.ndarray], steps: int) -> tuple[Hits, np.ndarray]:
        """Follow orbits for so many steps of the sweep; return their hits and amplitudes."""
        n = len(u)
        counts, time, every = np.full(n, -(-steps * self._dt // self._step), dtype=int), np.empty(n), np.zeros(n, int)
        if self._forced:
            period = self._forcing(parameters)
            every = np.ceil(period / self._step * (1 - ROUNDING)).astype(int)
            counts = np.maximum(counts // every, 1) * every
            time[:] = counts // every * period
        else:
            time[:] = counts * self._step
        dt, c = time / counts, self._program.coefficient_values(parameters)
        amplitude, lists = np.empty_like(u), _Lists(u.shape[1])
        for cells, states in self._flow.record(METHOD, u, parameters, time, counts):
            amplitude[cells] = amplitudes(states[::SPARSE], self._circle)
            if self._forced:
                lists.add(*_strobed(states, every[cells], cells, dt[cells]))
                continue
            at, column = crossed(self._event, self._direction, states, c[:, cells])
            where = cells[column]
            pair = (states[at, :, column], states[at + 1, :, column])
            later, state = between(self._program, self._event, pair, c[:, where], dt[where])
            lists.add(where, later + at * dt[where], state)
        return lists.table(n), amplitude

    def _attempt(
        self, hits: Hits, amplitude: np.ndarray, parameters: Sequence[np.ndarray], count: np.ndarray
    ) -> tuple[Cycles, np.ndarray]:
        """Close orbits after so many hits, (n,) int; return what is certified, and the number to try next or 0."""
        rows = np.arange(len(count))
        last, before = hits.state[:, 0], hits.state[rows, count]
        period = hits.time[:, 0] - hits.time[rows, count]
        if self._forced:
            period = self._forcing(parameters) * count
        closed = self._shooting.close(last, period, parameters, amplitude, count if self._forced else np.ones_like(count))
        multipliers, exponents = floquet(closed)
        sizes = np.abs(multipliers)
        if not self._forced:
            sizes[rows, np.argmin(np.abs(multipliers - 1.0), axis=1)] = 0.0
        radius = sizes.max(axis=1)
        doubled = closed.found & (multipliers.real.min(axis=1) <= -UNIT)
        again = np.where(doubled & (hits.count > 2 * count) & (2 * count < MOST_HITS), 2 * count, 0)
        closed.found[:] &= radius < UNIT
        tour = self._tour(closed, parameters, count)
        cycles = self._describe(closed, tour, multipliers, exponents)
        again = np.where(closed.found & (cycles.hits < tour.hits.count), cycles.hits, again)
        real = closed.found & (again == 0) & (size(tour.amplitude, amplitude) >= SHRUNK) | cycles.resting
        scale = np.where(cycles.resting[:, None], REST_SCALE * (1.0 + np.abs(closed.point)), tour.amplitude)
        multiple = count if self._forced else None
        closed.found[:] = real
        tube = examine_tube(
            self._flow, self._method, self._dt, closed, radius, scale, self._circle, parameters, (last, before), multiple
        )
        cycles.found[:] = tube.inside
        return cycles, again

    def _tour(self, closed: Closed, parameters: Sequence[np.ndarray], multiple: np.ndarray) -> _Tour:
        """Go round closed orbits once, beginning half a step behind the point, so that it is hit within a step."""
        n, dimension = closed.point.shape
        group = np.flatnonzero(closed.found)
        own, period, steps = [p[group] for p in parameters], closed.period[group], closed.steps[group]
        c, dt, start = self._program.coefficient_values(own), period / steps, closed.point[group]
        if not self._forced:
            start = step(self._program, METHOD, 0.5 * dt, start.T, c).T
        amplitude, lists = np.ones((n, dimension)), _Lists(dimension)
        marked: list[list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = [[] for _ in (None, *self._signs)]
        for part, states in self._flow.record(METHOD, start, own, period, steps):
            amplitude[group[part]] = amplitudes(states, self._circle)
            if self._forced:
                every = steps[part] // multiple[group[part]]
                lists.add(*_strobed(states[:-1], every, group[part], dt[part]))
                continue
            for found, signs in zip(marked, (None, *self._signs), strict=True):
                at, column = crossed(self._seen(signs), self._direction, states, c[:, part])
                if signs is not None:  # one hit of the mirror image tells
                    column, first = np.unique(column, return_index=True)
                    at = at[first]
                found.append((part[column], at, states[at, :, column]))
        if not self._forced:
            lists.add(*self._exact(None, marked[0], group, c, dt))
        hits = lists.table(n)
        hits.state[...] = self._wrapped(hits.state)
        symmetric = np.zeros(n, dtype=bool)
        for found, signs in zip(marked[1:], self._signs, strict=True):
            if self._forced:
                cells, state = group, closed.point[group]
            else:
                cells, _, state = self._exact(signs, found, group, c, dt)
            away = shortest(hits.state[cells] - (signs * state)[:, None, :], self._circle)
            near = size(away, amplitude[cells][:, None, :]) <= SAME
            symmetric[cells[near.any(axis=1)]] = True
        symmetry = np.where(symmetric, CycleSymmetry.SYMMETRIC, CycleSymmetry.MIRRORED).astype(np.int8)
        return _Tour(hits, amplitude, symmetry if self._signs else np.zeros(n, dtype=np.int8))

    def _seen(self, signs: np.ndarray | None) -> Event:
        """Return the event of the section, or of its mirror image."""
        if signs is None:
            return self._event
        return lambda u, c: self._event(u * signs.reshape(-1, *[1] * (u.ndim - 1)), c)

    def _exact(
        self,
        signs: np.ndarray | None,
        marked: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]],
        group: np.ndarray,
        coefficients: np.ndarray,
        dt: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return cells, times and states of hits to rounding, from the steps in which they happen."""
        if not marked:
            return np.zeros(0, dtype=int), np.zeros(0), np.zeros((0, len(self._circle)))
        part, at, begin = (np.concatenate(pieces) for pieces in zip(*marked, strict=True))
        event, c = self._seen(signs), coefficients[:, part]
        time, state = locate(self._program, METHOD, dt[part], event, np.ascontiguousarray(begin.T), c)
        return group[part], time + at * dt[part], state.T

    def _describe(self, closed: Closed, tour: _Tour, multipliers: np.ndarray, exponents: np.ndarray) -> Cycles:
        """Return closed orbits as cycles, with the hits of their least period."""
        cycles = Cycles.none(*closed.point.shape)
        least = self._least(tour)
        cycles.found[:] = closed.found & (least > 0)
        cycles.hits[:] = least
        cycles.period[:], cycles.symmetry[:] = closed.period, tour.symmetry
        cycles.point[:] = _last(tour.hits, tour.amplitude)
        cycles.multipliers[:], cycles.exponents[:] = multipliers, exponents
        if self._forced:
            still = (tour.amplitude <= REST * (1.0 + np.abs(closed.point))).all(axis=1)
            cycles.resting[:] = closed.found & still
        return cycles

    def _least(self, tour: _Tour) -> np.ndarray:
        """Return after how many of the exact hits of an orbit they repeat themselves, (n,) int."""
        hits, least = tour.hits, tour.hits.count.copy()
        for part in range(1, int(hits.count.max(initial=0)) // 2 + 1):
            cells = np.flatnonzero((hits.count % part == 0) & (part < least))
            states = hits.state[cells]
            away = size(shortest(states[:, part:] - states[:, :-part], self._circle), tour.amplitude[cells][:, None, :])
            same = ~(away > SAME).any(axis=1)
            least[cells[same]] = part
        return least

    def _wrapped(self, states: np.ndarray) -> np.ndarray:
        """Return states with angles in one turn that begins a rounding error below zero."""
        finite = np.isfinite(self._circle)
        turn = np.where(finite, self._circle, 1.0)
        slack = ROUNDING * turn
        return np.where(finite, np.mod(states + slack, turn) - slack, states)

    def _forcing(self, parameters: Sequence[np.ndarray]) -> np.ndarray:
        """Return the periods of the forcing, (n,)."""
        period = self._model.forcing_period
        assert period is not None
        named = dict(zip(self._model.parameter_names, parameters, strict=True))
        wanted = {name: named[name] for name in inspect.signature(period).parameters}
        return np.broadcast_to(np.asarray(period(**wanted), dtype=float), (len(parameters[0]),))


class _Lists:
    """Hits that are found in parts: cells, times and states."""

    def __init__(self, dimension: int) -> None:
        self._parts = [(np.zeros(0, dtype=int), np.zeros(0), np.zeros((0, dimension)))]

    def add(self, cells: np.ndarray, times: np.ndarray, states: np.ndarray) -> None:
        """Add hits in any order."""
        self._parts.append((cells, times, states))

    def table(self, n: int) -> Hits:
        """Return the table of the last hits of n cells."""
        cells, times, states = (np.concatenate(part) for part in zip(*self._parts, strict=True))
        order = np.lexsort((times, cells))
        return collect(cells[order], times[order], states[order], n)


def _strobed(
    states: np.ndarray, every: np.ndarray, cells: np.ndarray, dt: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return cells, times and states at phase 0, from states (steps, D, m) and the steps of a forcing's period."""
    at, column = np.nonzero(np.arange(len(states))[:, None] % every == 0)
    return cells[column], at * dt[column], states[at, :, column]


def _last(hits: Hits, amplitude: np.ndarray) -> np.ndarray:
    """Return the hit that comes last in the order of the states, up to rounding, (n, D)."""
    kept = np.isfinite(hits.time)
    for i in range(hits.state.shape[2]):
        value = np.where(kept, hits.state[:, :, i], -np.inf)
        kept &= value >= (value.max(axis=1) - ROUNDING * amplitude[:, i])[:, None]
    return hits.state[np.arange(len(kept)), np.argmax(kept, axis=1)]
