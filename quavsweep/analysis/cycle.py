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
from quavsweep.analysis.shooting import METHOD, Closed, Shooting, floquet
from quavsweep.analysis.tube import UNIT, examine_tube
from quavsweep.clock import Clock
from quavsweep.codes import CycleSymmetry
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program
from quavsweep.models import Model

RATIO = 2  # steps of a method of low order that one of order 8 takes at once
ATTEMPTS = 3  # guesses of the period: the first, its divisor or double, and once more
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
            2.0 * self._step,
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
            cells, hits, amplitude = self._stretch(u, parameters, steps)
            own = [p[cells] for p in parameters]
            count = nearest_return(hits, amplitude, self._circle)
            for _ in range(ATTEMPTS):
                open_ = np.flatnonzero(count)
                if not open_.size:
                    break
                some = Hits(hits.count[open_], hits.time[open_], hits.state[open_])
                found, again = self._attempt(some, amplitude[open_], [p[open_] for p in own], count[open_])
                cycles.put(cells[open_], found, found.found)
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
            for count in np.unique(steps := np.ceil(period / self._step).astype(int)):
                cells = np.flatnonzero(steps == count)
                own = [p[cells] for p in parameters]
                for part, states in self._flow.record(METHOD, u[cells], own, period[cells] / count, int(count)):
                    amplitude[cells[part]] = amplitudes(states, self._circle)
            closed = self._shooting.close(u, period, parameters, amplitude, multiple)
            return self._describe(closed, self._tour(closed, parameters, multiple), multiple)

    def _stretch(
        self, u: np.ndarray, parameters: Sequence[np.ndarray], steps: int
    ) -> tuple[np.ndarray, Hits, np.ndarray]:
        """Follow orbits for so many steps; return cells in some order, their hits and amplitudes."""
        all_cells, times, states, amplitude = [], [], [], []
        n, per_period = len(u), np.zeros(len(u), dtype=int)
        if self._forced:
            per_period = np.ceil(self._forcing(parameters) / self._step * (1 - 1e-9)).astype(int)
        for every in np.unique(per_period):
            group = np.flatnonzero(per_period == every)
            own = [p[group] for p in parameters]
            count = int(np.ceil(steps * self._dt / self._step))
            step_ = np.full(group.size, self._step)
            if every:
                count = max(1, count // int(every)) * int(every)
                step_ = self._forcing(own) / every
            c = self._program.coefficient_values(own)
            for part, table in self._flow.record(METHOD, u[group], own, step_, count):
                amplitude.append((group[part], amplitudes(table, self._circle)))
                if every:
                    at, column = np.tile(np.arange(0, count + 1, every), part.size), np.repeat(
                        np.arange(part.size), count // every + 1
                    )
                    time, state = at * step_[part][column], table[at, :, column]
                else:
                    at, column = crossed(self._event, self._direction, table, c[:, part])
                    pair = (table[at, :, column], table[at + 1, :, column])
                    time, state = between(self._program, self._event, pair, c[:, part[column]], step_[part[column]])
                    time = time + at * step_[part[column]]
                all_cells.append(group[part[column]])
                times.append(time)
                states.append(state)
        cells, time, state = (np.concatenate(x) if x else np.zeros(0) for x in (all_cells, times, states))
        sizes = np.ones_like(u)
        for part, value in amplitude:
            sizes[part] = value
        order = np.argsort(cells, kind="stable")
        hits = collect(cells[order].astype(int), time[order], state[order].reshape(-1, u.shape[1]), n)
        return np.arange(n), hits, sizes

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
        tour = self._tour(closed, parameters, count)
        cycles = self._describe(closed, tour, count)
        again = np.where(closed.found & (cycles.hits < tour.hits.count), cycles.hits, 0)
        sizes = np.abs(cycles.multipliers)
        if not self._forced:
            neutral = np.argmin(np.abs(cycles.multipliers - 1.0), axis=1)
            sizes[rows, neutral] = 0.0
        radius = sizes.max(axis=1)
        doubled = closed.found & (again == 0) & (cycles.multipliers.real.min(axis=1) <= -UNIT)
        again = np.where(doubled & (hits.count > 2 * count) & (2 * count < MOST_HITS), 2 * count, again)
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
        amplitude = np.ones((n, dimension))
        symmetric = np.zeros(n, dtype=bool)
        lists: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        mirrored: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        for count in np.unique(closed.steps[closed.found]):
            group = np.flatnonzero(closed.found & (closed.steps == count))
            own = [p[group] for p in parameters]
            c, dt = self._program.coefficient_values(own), closed.period[group] / count
            start = closed.point[group]
            if not self._forced:
                start = step(self._program, METHOD, 0.5 * dt, start.T, c).T
            for part, states in self._flow.record(METHOD, start, own, dt, int(count)):
                cells = group[part]
                amplitude[cells] = amplitudes(states, self._circle)
                if self._forced:
                    for j, cell in enumerate(cells):
                        at = np.arange(multiple[cell]) * (count // multiple[cell])
                        lists.append((np.full(at.size, cell), at * dt[part[j]], states[at, :, j]))
                        mirrored += [(np.full(1, cell), np.zeros(1), states[:1, :, j] * s) for s in self._signs]
                    continue
                lists.append(self._exact(self._event, states, c[:, part], dt[part], cells))
                mirrored += [self._mirrored(s, states, c[:, part], dt[part], cells) for s in self._signs]
        hits = _table(lists, n, dimension)
        hits.state[...] = self._wrapped(hits.state)
        for cells, _, states in mirrored:
            away = size(shortest(hits.state[cells] - states[:, None, :], self._circle), amplitude[cells][:, None, :])
            symmetric[cells[np.nanmin(away, axis=1, initial=np.inf) <= SAME]] = True
        symmetry = np.where(symmetric, CycleSymmetry.SYMMETRIC, CycleSymmetry.MIRRORED).astype(np.int8)
        return _Tour(hits, amplitude, symmetry if self._signs else np.zeros(n, dtype=np.int8))

    def _exact(
        self, event: Event, states: np.ndarray, coefficients: np.ndarray, dt: np.ndarray, cells: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return cells, times and states of the hits of a recorded stretch, (1 + steps, D, m), to rounding."""
        at, column = crossed(event, self._direction, states, coefficients)
        begin = np.ascontiguousarray(states[at, :, column].T)
        time, state = locate(self._program, METHOD, dt[column], event, begin, coefficients[:, column])
        return cells[column], time + at * dt[column], state.T

    def _mirrored(
        self, signs: np.ndarray, states: np.ndarray, coefficients: np.ndarray, dt: np.ndarray, cells: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return a hit of each orbit's mirror image, as far as it has one."""

        def event(u: np.ndarray, c: np.ndarray) -> np.ndarray:
            return self._event(u * signs.reshape(-1, *[1] * (u.ndim - 1)), c)

        cell, time, state = self._exact(event, states, coefficients, dt, cells)
        cell, first = np.unique(cell, return_index=True)
        return cell, time[first], state[first] * signs

    def _describe(self, closed: Closed, tour: _Tour, multiple: np.ndarray) -> Cycles:
        """Return closed orbits as cycles, with the hits of their least period."""
        cycles = Cycles.none(*closed.point.shape)
        multipliers, exponents = floquet(closed)
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


def _table(lists: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray]], n: int, dimension: int) -> Hits:
    """Return the table of hits that were found in parts."""
    empty = (np.zeros(0, dtype=int), np.zeros(0), np.zeros((0, dimension)))
    cells, times, states = (np.concatenate(part) for part in zip(empty, *lists, strict=True))
    order = np.lexsort((times, cells))
    return collect(cells[order], times[order], states[order], n)


def _last(hits: Hits, amplitude: np.ndarray) -> np.ndarray:
    """Return the hit that comes last in the order of the states, up to rounding, (n, D)."""
    kept = np.isfinite(hits.time)
    for i in range(hits.state.shape[2]):
        value = np.where(kept, hits.state[:, :, i], -np.inf)
        kept &= value >= (value.max(axis=1) - ROUNDING * amplitude[:, i])[:, None]
    return hits.state[np.arange(len(kept)), np.argmax(kept, axis=1)]
