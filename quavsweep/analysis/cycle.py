"""Cycles certified: found by returns to the section, closed by shooting, stable, and with the orbit in their tube."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from quavsweep.analysis.floquet import floquet
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.own_cycle import examine_own_cycle
from quavsweep.analysis.returns import (
    MOST_HITS,
    ROUNDING,
    HitList,
    Hits,
    amplitudes,
    between,
    circles,
    crossed,
    nearest_return,
    section_of,
    size,
    strobed,
)
from quavsweep.analysis.shooting import METHOD, Closed, Shooting, grade
from quavsweep.analysis.tour import Guide, Tour
from quavsweep.analysis.tube import UNIT, examine_tube
from quavsweep.clock import Clock
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program
from quavsweep.models import Model

RATIO = 4  # steps of a method of low order that one of order 8 takes at once where that need not be exact
ATTEMPTS = 3  # guesses of the period: the first, its divisor or double, and once more
SPARSE = 4  # steps of a stretch of which one is enough to see how far an orbit goes
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
    close : (n,) bool
        From `find`: a stable cycle closes near the orbit, in the tube or not: an orbit on a torus has none.
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
    close: np.ndarray
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
class _Stretch:
    """What n orbits did: where they began, their hits and amplitudes, and the step with which they were followed."""

    start: np.ndarray
    hits: Hits
    amplitude: np.ndarray
    dt: np.ndarray

    def take(self, cells: np.ndarray) -> _Stretch:
        """Return those of some cells."""
        return _Stretch(self.start[cells], self.hits.take(cells), self.amplitude[cells], self.dt[cells])


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
        # Across a kink no method has a high order.
        self._step = self._dt * (1 if method.order >= METHOD.order or program.switches else RATIO)
        self._event, self._direction = section_of(model, program)
        self._circle = circles(model)
        self._forced = program.forced
        signs = [np.array(s, dtype=float) for s in model.symmetries if any(sign != 1 for sign in s)]
        self._guide = Guide(self._flow, self._event, self._direction, signs, self._circle, self._forced)
        section = model.section
        self._shooting = Shooting(
            self._flow,
            self._circle,
            None if self._forced else self._event,
            model.state_names.index(section.of) if section else 0,
            section is None or section.at is None,
            max(self._step, 2.0 * self._dt),
        )

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
            stretch = self._follow(u, parameters, steps)
            count = nearest_return(stretch.hits, stretch.amplitude, self._circle)
            for _ in range(ATTEMPTS):
                open_ = np.flatnonzero(count)
                if not open_.size:
                    break
                own = [p[open_] for p in parameters]
                found, count[open_] = self._attempt(stretch.take(open_), own, count[open_])
                cycles.put(open_, found, found.found)
                cycles.close[open_] |= found.close
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
                multiple = np.maximum(np.rint(period / self._program.forcing_periods(parameters)).astype(int), 1)
            amplitude = np.empty_like(u)
            steps = grade(period / self._step)
            for cells, states in self._flow.record(METHOD, u, parameters, period, steps):
                amplitude[cells] = amplitudes(states, self._circle)
            closed = self._shooting.close(u, period, parameters, amplitude, multiple)
            return self._describe(
                closed, self._guide.tour(closed, parameters, multiple), *floquet(self._flow, closed, parameters)
            )

    def _follow(self, u: np.ndarray, parameters: Sequence[np.ndarray], steps: int) -> _Stretch:
        """Follow orbits for so many steps of the sweep."""
        counts, time, every = self._times(len(u), parameters, steps)
        dt, c = time / counts, self._program.coefficient_values(parameters)
        amplitude, hits = np.empty_like(u), HitList(u.shape[1])
        for cells, states in self._flow.record(METHOD, u, parameters, time, counts):
            amplitude[cells] = amplitudes(states[::SPARSE], self._circle)
            if self._forced:
                at, column = strobed(states, every[cells])
                state = states[at, :, column]
                hits.add(cells[column], at * dt[cells[column]], state, state)
                continue
            at, column = crossed(self._event, self._direction, states, c[:, cells])
            where, begin = cells[column], states[at, :, column]
            pair = (begin, states[at + 1, :, column])
            later, state = between(self._program, self._event, pair, c[:, where], dt[where])
            hits.add(where, later + at * dt[where], state, begin)
        return _Stretch(u, hits.table(len(u)), amplitude, dt)

    def _times(self, n: int, parameters: Sequence[np.ndarray], steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return for a stretch of so many steps of the sweep: long steps, its length, long steps in a forcing."""
        count = max(1, round(steps * self._dt / self._step))
        counts = np.full(n, count)
        if not self._forced:
            return counts, counts * self._step, counts
        period = self._program.forcing_periods(parameters)
        every = np.ceil(period / self._step * (1 - ROUNDING)).astype(int)
        times = np.maximum(counts // every, 1)
        return times * every, times * period, every

    def _attempt(
        self, stretch: _Stretch, parameters: Sequence[np.ndarray], count: np.ndarray
    ) -> tuple[Cycles, np.ndarray]:
        """Close orbits after so many hits, (n,) int; return what is certified, and the number to try next or 0."""
        hits, rows = stretch.hits, np.arange(len(count))
        period, multiple = hits.time[:, 0] - hits.time[rows, count], np.ones_like(count)
        if self._forced:
            period, multiple = self._program.forcing_periods(parameters) * count, count
        closed = self._shooting.close(
            hits.state[:, 0], period, parameters, stretch.amplitude, multiple, to_be_stable=True
        )
        multipliers, exponents = floquet(self._flow, closed, parameters)
        slowest = self._slowest(multipliers)
        doubled = closed.found & (multipliers.real.min(axis=1) <= -UNIT)
        again = np.where(doubled & (hits.count > 2 * count) & (2 * count < MOST_HITS), 2 * count, 0)
        closed.found[:] &= np.abs(slowest) < UNIT
        tour = self._guide.tour(closed, parameters, multiple)
        cycles = self._describe(closed, tour, multipliers, exponents)
        again = np.where(closed.found & (tour.least < tour.hits.count), tour.least, again)
        large = size(tour.amplitude, stretch.amplitude) >= SHRUNK
        closed.found[:] &= (again == 0) & (tour.least > 0) & (large | cycles.resting)
        cycles.close[:] = closed.found
        scale = np.where(cycles.resting[:, None], REST_SCALE * (1.0 + np.abs(closed.point)), tour.amplitude)
        near = self._near(closed.found, stretch, parameters, count)
        cycles.found[:] = examine_tube(
            self._flow,
            self._method,
            self._dt,
            closed,
            slowest,
            scale,
            self._circle,
            parameters,
            near,
            multiple if self._forced else None,
        ).inside
        closed.found[:] &= ~cycles.found
        cycles.found[:] |= examine_own_cycle(
            self._shooting,
            self._method,
            self._dt,
            closed,
            tour.amplitude,
            parameters,
            stretch.start,
            self._direction,
        )
        return cycles, again

    def _near(
        self, which: np.ndarray, stretch: _Stretch, parameters: Sequence[np.ndarray], count: np.ndarray
    ) -> list[np.ndarray]:
        """Return the last hits and those `count` and twice as many before, (n, D), exactly where asked for."""
        hits, rows, cells = stretch.hits, np.arange(len(count)), np.flatnonzero(which)
        columns = [np.minimum(turns * count, hits.time.shape[1] - 1) for turns in (0, 1, 2)]
        near = [hits.state[rows, column] for column in columns]
        if not self._forced:
            begin = np.concatenate([hits.begin[cells, column[cells]] for column in columns])
            own, dt = [np.tile(p[cells], len(columns)) for p in parameters], np.tile(stretch.dt[cells], len(columns))
            exact = self._guide.exact(begin, own, dt)[1]
            for state, part in zip(near, np.split(exact, len(columns)), strict=True):
                state[cells] = part
        return near

    def _slowest(self, multipliers: np.ndarray) -> np.ndarray:
        """Return the multiplier of largest size but the neutral one, which forced systems do not have, (n,)."""
        sizes, rows = np.abs(multipliers), np.arange(len(multipliers))
        if not self._forced:
            sizes[rows, np.argmin(np.abs(multipliers - 1.0), axis=1)] = -1.0
        return np.asarray(multipliers[rows, np.argmax(sizes, axis=1)])

    def _describe(self, closed: Closed, tour: Tour, multipliers: np.ndarray, exponents: np.ndarray) -> Cycles:
        """Return closed orbits as cycles, with the hits of their least period."""
        resting = np.zeros(len(tour.least), dtype=bool)
        if self._forced:
            resting = closed.found & (tour.amplitude <= REST * (1.0 + np.abs(closed.point))).all(axis=1)
        found = closed.found & (tour.least > 0)
        hits = tour.least
        return Cycles(
            found, found.copy(), resting, closed.period, hits, tour.symmetry, tour.point, multipliers, exponents
        )
