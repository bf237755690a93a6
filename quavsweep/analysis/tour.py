"""Going round closed orbits: their exact hits, amplitudes, least periods, and whether their mirror images are they."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quavsweep.analysis.event import Event, locate
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.returns import ROUNDING, HitList, Hits, amplitudes, crossed, shortest, size, strobed
from quavsweep.analysis.shooting import METHOD, Closed
from quavsweep.codes import CycleSymmetry

SAME = 1e-6  # distance in amplitudes below which two exact hits are one
FINER = 16  # steps for one, where equations have kinks

Marks = list[tuple[np.ndarray, np.ndarray, np.ndarray]]  # cells, steps, and the states at their beginnings


@dataclass(frozen=True)
class Tour:
    """One period of n closed orbits.

    Parameters
    ----------
    hits : Hits
        Exact; angles in one turn.
    amplitude : (n, D) float64
    symmetry : (n,) int8
        Codes of `CycleSymmetry`.
    least : (n,) int
        After how many hits they repeat themselves; 0 where nothing closes.
    point : (n, D) float64
        The hit that comes last in the order of the states, values counting as equal up to 1e-9 of the amplitude.
    """

    hits: Hits
    amplitude: np.ndarray
    symmetry: np.ndarray
    least: np.ndarray
    point: np.ndarray


@dataclass(frozen=True)
class Guide:
    """Shows closed orbits of one model.

    Parameters
    ----------
    flow : Flow
    event, direction
        The section.
    signs : sequence of (D,) float64
        The model's symmetries but the identity.
    circle : (D,) float64
        Turns of angles, infinite for other states.
    forced : bool
        Whether hits are the states at phase 0 instead.
    """

    flow: Flow
    event: Event
    direction: str
    signs: Sequence[np.ndarray]
    circle: np.ndarray
    forced: bool

    def tour(self, closed: Closed, parameters: Sequence[np.ndarray], multiple: np.ndarray) -> Tour:
        """Go round the orbits that close; in a forced system, `multiple` periods of the forcing, (n,) int."""
        n, dimension = closed.point.shape
        group = np.flatnonzero(closed.found)
        part, own = closed.take(group), [p[group] for p in parameters]
        some = self._forced(part, own, multiple[group]) if self.forced else self._free(part, own)
        found, amplitude, symmetric = some
        hits = HitList(dimension)
        hits.add(group[found[0]], *found[1:])
        table = hits.table(n)
        sizes = np.ones((n, dimension))
        sizes[group] = amplitude
        symmetry = np.zeros(n, dtype=np.int8)
        if self.signs:
            symmetry[group] = np.where(symmetric, CycleSymmetry.SYMMETRIC, CycleSymmetry.MIRRORED)
        return Tour(table, sizes, symmetry, _least(table, sizes, self.circle), _last(table, sizes))

    def exact(
        self,
        begin: np.ndarray,
        parameters: Sequence[np.ndarray],
        dt: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return when, (k,), and in which states, (k, D), steps that begin in (k, D) hit the section, to rounding."""
        if not len(begin):
            return np.zeros(0), begin
        c, after = self.flow.program.coefficient_values(parameters), self.flow.steps_from(METHOD, begin, parameters)
        time, state = locate(after, dt, self.event, np.ascontiguousarray(begin.T), c)
        return time, state.T

    def _forced(
        self, closed: Closed, parameters: Sequence[np.ndarray], multiple: np.ndarray
    ) -> tuple[tuple[np.ndarray, ...], np.ndarray, np.ndarray]:
        """Return hits, amplitudes and symmetry of a forced system's orbits; a mirror image has the same phase."""
        amplitude, dt, found = np.empty_like(closed.point), closed.period / closed.steps, []
        for cells, states in self.flow.record(METHOD, closed.point, parameters, closed.period, closed.steps):
            amplitude[cells] = amplitudes(states, self.circle)
            at, column = strobed(states[:-1], closed.steps[cells] // multiple[cells])
            found.append((cells[column], at * dt[cells[column]], states[at, :, column]))
        cells, times, states = _joined(found, closed.point.shape[1])
        states = self._wrapped(states)
        symmetric = np.zeros(len(amplitude), dtype=bool)
        for signs in self.signs:
            symmetric |= self._same(cells, states, np.arange(len(amplitude)), closed.point * signs, amplitude)
        return (cells, times, states, states), amplitude, symmetric

    def _free(
        self, closed: Closed, parameters: Sequence[np.ndarray]
    ) -> tuple[tuple[np.ndarray, ...], np.ndarray, np.ndarray]:
        """Return hits, amplitudes and symmetry of an autonomous system's orbits.

        They begin half a step behind the point, so that it is hit within a step and not at its end.
        """
        # Steps across a kink are of low order, so there they have to be short.
        steps = closed.steps * (FINER if self.flow.program.switches else 1)
        amplitude, dt = np.empty_like(closed.point), closed.period / steps
        c = self.flow.program.coefficient_values(parameters)
        start = self.flow.steps_from(METHOD, closed.point, parameters)(0.5 * dt, np.arange(len(dt))).T
        views = [None, *self.signs]
        marks: list[Marks] = [[] for _ in views]
        for cells, states in self.flow.record(METHOD, start, parameters, closed.period, steps):
            amplitude[cells] = amplitudes(states, self.circle)
            for found, signs in zip(marks, views, strict=True):
                at, column = crossed(self._seen(signs), self.direction, states, c[:, cells])
                if signs is not None:  # one hit of the mirror image tells
                    column, first = np.unique(column, return_index=True)
                    at = at[first]
                found.append((cells[column], at, states[at, :, column]))
        dimension = closed.point.shape[1]
        cells, at, begin = _joined(marks[0], dimension)
        # A step of which the mirror image hits is mirrored to one that hits itself, so one call does for all.
        images = [_joined(found, dimension) for found in marks[1:]]
        mirrored = [state * signs for (_, _, state), signs in zip(images, self.signs, strict=True)]
        of = np.concatenate([cells, *(seen for seen, _, _ in images)])
        times, states = self.exact(np.concatenate([begin, *mirrored]), [p[of] for p in parameters], dt[of])
        states, *mirrored = np.split(states, np.cumsum([len(cells), *(len(state) for state in mirrored)])[:-1])
        states = self._wrapped(states)
        symmetric = np.zeros(len(amplitude), dtype=bool)
        for (seen, _, _), state in zip(images, mirrored, strict=True):
            symmetric |= self._same(cells, states, seen, state, amplitude)
        return (cells, times[: len(cells)] + at * dt[cells], states, begin), amplitude, symmetric

    def _same(
        self, cells: np.ndarray, states: np.ndarray, seen: np.ndarray, mirrored: np.ndarray, amplitude: np.ndarray
    ) -> np.ndarray:
        """Return which cells have a hit, (k,) and (k, D), where their mirror image, (m,) and (m, D), has one."""
        n = len(amplitude)
        image = np.full((n, states.shape[1]), np.nan)
        image[seen] = mirrored
        near = size(shortest(states - image[cells], self.circle), amplitude[cells]) <= SAME
        return np.bincount(cells[near], minlength=n) > 0

    def _seen(self, signs: np.ndarray | None) -> Event:
        """Return the event of the section, or of its mirror image."""
        if signs is None:
            return self.event
        return lambda u, c: self.event(u * signs.reshape(-1, *[1] * (u.ndim - 1)), c)

    def _wrapped(self, states: np.ndarray) -> np.ndarray:
        """Return states with angles in one turn that begins a rounding error below zero."""
        finite = np.isfinite(self.circle)
        turn = np.where(finite, self.circle, 1.0)
        slack = ROUNDING * turn
        return np.where(finite, np.mod(states + slack, turn) - slack, states)


def _joined(parts: Marks, dimension: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return lists that were found in parts as one."""
    empty = (np.zeros(0, dtype=int), np.zeros(0, dtype=int), np.zeros((0, dimension)))
    cells, at, states = (np.concatenate(pieces) for pieces in zip(empty, *parts, strict=True))
    return cells, at, states


def _least(hits: Hits, amplitude: np.ndarray, circle: np.ndarray) -> np.ndarray:
    """Return after how many of the exact hits of an orbit they repeat themselves, (n,) int."""
    least = hits.count.copy()
    for part in range(1, int(hits.count.max(initial=0)) // 2 + 1):
        cells = np.flatnonzero((hits.count % part == 0) & (part < least))
        states = hits.state[cells]
        away = size(shortest(states[:, part:] - states[:, :-part], circle), amplitude[cells][:, None, :])
        least[cells[~(away > SAME).any(axis=1)]] = part
    return least


def _last(hits: Hits, amplitude: np.ndarray) -> np.ndarray:
    """Return the hit that comes last in the order of the states, up to rounding, (n, D)."""
    kept = np.isfinite(hits.time)
    for i in range(hits.state.shape[2]):
        value = np.where(kept, hits.state[:, :, i], -np.inf)
        kept &= value >= (value.max(axis=1) - ROUNDING * amplitude[:, i])[:, None]
    return np.asarray(hits.state[np.arange(len(kept)), np.argmax(kept, axis=1)])
