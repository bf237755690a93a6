"""What dense measures write down: states at even times, on sections and at maxima, peaks, first passages.

The observer sees the states of all steps, chunk by chunk. It marks the steps in which something happens, and finds
what it was exactly once per segment for all of them together, because a call of NumPy costs more than a few cells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from quavsweep.analysis.event import Event, crossings, locate, slope, steps_from
from quavsweep.clock import Clock
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program
from quavsweep.measures import Evidence, FirstTime, LastTime, Measures, Orbit, Peak, Samples
from quavsweep.models import Model


@dataclass(frozen=True)
class Scene:
    """What all watchers share: the equations, the clock, and the tile's evidence that they write into.

    Parameters
    ----------
    coefficients : (C, n) float64
        Of all cells of the tile.
    evidence : dict
        Arrays of all cells of the tile.
    """

    model: Model
    program: Program
    method: ButcherTable
    clock: Clock
    coefficients: np.ndarray
    evidence: Evidence

    def state(self, name: str) -> int:
        """Return the index of a state."""
        return self.model.state_names.index(name)


@dataclass(frozen=True)
class Chunk:
    """The states of some cells over some steps.

    Parameters
    ----------
    cells : (m,) int
        Their rows in the evidence.
    first : int
        Step of the first states.
    u : (1 + steps, D, m) float64
    """

    cells: np.ndarray
    first: int
    u: np.ndarray

    @property
    def last(self) -> int:
        """Step of the last states."""
        return self.first + len(self.u) - 1


@dataclass
class Crossings:
    """Finds where a function of the state crosses zero: marks steps at once, locates the crossings when asked.

    Parameters
    ----------
    event : callable
        From states (D, ...), coefficients (C, ...) and time to values.
    direction : str
        `up`, `down`, `both` or `beyond`, see `crossings`.
    first, last : int
        Steps between which crossings count.
    """

    scene: Scene
    event: Event
    direction: str
    first: int
    last: int
    _marked: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)

    def mark(self, chunk: Chunk) -> None:
        """Remember the steps of a chunk in which the event happens."""
        if chunk.last <= self.first or chunk.first >= self.last:
            return
        coefficients = self.scene.coefficients[:, None, chunk.cells]
        clock, steps = self.scene.clock, np.arange(chunk.first, chunk.last + 1)[:, None]
        time = (clock.phase(steps),) if clock.period_steps else ()
        value = self.event(chunk.u.transpose(1, 0, 2), coefficients, *time)
        steps, column = np.nonzero(crossings(value[:-1], value[1:], self.direction))
        inside = (chunk.first + steps >= self.first) & (chunk.first + steps < self.last)
        steps, column = steps[inside], column[inside]
        if steps.size:
            self._marked.append((chunk.cells[column], chunk.first + steps, chunk.u[steps, :, column]))

    def take(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return cells (k,), times (k,) and states (k, D) of what was marked, by cell and time, and forget it."""
        if not self._marked:
            return np.zeros(0, dtype=int), np.zeros(0), np.zeros((0, len(self.scene.model.states)))
        cells, steps, u = (np.concatenate(part) for part in zip(*self._marked, strict=True))
        self._marked.clear()
        order = np.lexsort((steps, cells))
        cells, steps, u = cells[order], steps[order], u[order].T
        scene, clock = self.scene, self.scene.clock
        c, t = scene.coefficients[:, cells], clock.phase(steps)
        after = steps_from(scene.program, scene.method, u, c, t)
        time, state = locate(after, clock.dt, self.event, u, c, t)
        return cells, steps * clock.dt + time, state.T


class Watcher:
    """Serves one measure."""

    def see(self, chunk: Chunk) -> None:
        """Look at the states of a chunk."""

    def settle(self) -> None:
        """Write down what has been seen since the last call."""

    def void(self, cells: np.ndarray) -> None:
        """Take back what means nothing for cells that diverged just now."""


class Strobe(Watcher):
    """Stores the state after even numbers of steps."""

    def __init__(self, steps: range, write: Callable[[np.ndarray, range, np.ndarray], None]) -> None:
        self._steps, self._write = steps, write

    def see(self, chunk: Chunk) -> None:
        """Store the states of a chunk that are due; the first of them was the last of the chunk before."""
        steps = self._steps
        begin = chunk.first if chunk.first == 0 else chunk.first + 1
        due = range(
            max(0, -((steps.start - begin) // steps.step)),
            min(len(steps), (chunk.last - steps.start) // steps.step + 1),
        )
        if due:
            rows = np.asarray(steps[due.start : due.stop]) - chunk.first
            self._write(chunk.cells, due, chunk.u[rows].transpose(2, 0, 1))


class SampleWatcher(Watcher):
    """Stores the states on a section or at maxima."""

    def __init__(self, scene: Scene, samples: Samples) -> None:
        self._scene, self._max = scene, samples.max
        first = scene.clock.transient_steps
        if samples.section is not None:
            index, at = scene.state(samples.section.of), samples.section.at
            self._crossings = Crossings(scene, lambda u, c, *t: u[index] - at, samples.section.direction, first, _END)
        else:
            event = slope(scene.program, scene.state(samples.maxima or scene.model.state_names[0]))
            self._crossings = Crossings(scene, event, "down", first, _END)

    def see(self, chunk: Chunk) -> None:
        """Mark the crossings of a chunk."""
        self._crossings.mark(chunk)

    def settle(self) -> None:
        """Append what was found to each cell's samples."""
        cells, times, states = self._crossings.take()
        _, begin, count = np.unique(cells, return_index=True, return_counts=True)
        number = np.arange(cells.size) - np.repeat(begin, count) + self._scene.evidence["sample_count"][cells]
        kept = number < self._max
        self._scene.evidence["samples"][cells[kept], number[kept]] = states[kept]
        self._scene.evidence["sample_time"][cells[kept], number[kept]] = times[kept]
        np.add.at(self._scene.evidence["sample_count"], cells, 1)


class PeakWatcher(Watcher):
    """Keeps the value of largest magnitude: at a turn of the state, or at an end of the window."""

    def __init__(self, scene: Scene, peak: Peak) -> None:
        self._scene, self._last = scene, peak.hold(scene.clock)
        self._states = [scene.state(name) for name in peak.of]
        self._turns = [Crossings(scene, slope(scene.program, i), "both", 0, self._last) for i in self._states]

    def see(self, chunk: Chunk) -> None:
        """Mark the turns of a chunk, and look at the ends of the window."""
        for turns in self._turns:
            turns.mark(chunk)
        for step in (0, self._last):
            if chunk.first <= step <= chunk.last:
                for column, i in enumerate(self._states):
                    time = np.full(chunk.cells.size, step * self._scene.clock.dt)
                    self._offer(column, chunk.cells, time, chunk.u[step - chunk.first, i])

    def settle(self) -> None:
        """Offer the turns that were found, of each cell the largest first."""
        for column, (i, turns) in enumerate(zip(self._states, self._turns, strict=True)):
            cells, times, states = turns.take()
            order = np.lexsort((times, -np.abs(states[:, i]), cells))
            first = order[np.unique(cells[order], return_index=True)[1]]
            self._offer(column, cells[first], times[first], states[first, i])

    def void(self, cells: np.ndarray) -> None:
        """Leave no peak where the orbit diverged before the end of the window."""
        unfinished = cells[self._scene.evidence["steps"][cells] - self._scene.clock.segment_steps < self._last]
        self._scene.evidence["peak"][unfinished] = np.nan
        self._scene.evidence["peak_time"][unfinished] = np.nan

    def _offer(self, column: int, cells: np.ndarray, times: np.ndarray, values: np.ndarray) -> None:
        peak = self._scene.evidence["peak"]
        better = ~(np.abs(values) <= np.abs(peak[cells, column])) & np.isfinite(values)
        peak[cells[better], column] = values[better]
        self._scene.evidence["peak_time"][cells[better], column] = times[better]


class FirstTimeWatcher(Watcher):
    """Keeps the first time beyond a limit."""

    def __init__(self, scene: Scene, first_time: FirstTime) -> None:
        limit, direction = first_time.limit
        index = scene.state(first_time.of)
        self._scene, self._index, self._limit = scene, index, limit
        self._sign = sign = 1.0 if direction == "up" else -1.0
        last = first_time.hold(scene.clock)
        self._crossings = Crossings(scene, lambda u, c, *t: sign * (u[index] - limit), "beyond", 0, last)

    def see(self, chunk: Chunk) -> None:
        """Mark the crossings of a chunk; an orbit may begin beyond the limit."""
        self._crossings.mark(chunk)
        if chunk.first == 0:
            beyond = self._sign * (chunk.u[0, self._index] - self._limit) > 0
            self._scene.evidence["first_time"][chunk.cells[beyond]] = 0.0

    def settle(self) -> None:
        """Keep the first crossing of each cell that has none yet."""
        cells, times, _ = self._crossings.take()
        cells, first = np.unique(cells, return_index=True)
        found = self._scene.evidence["first_time"]
        new = np.isnan(found[cells])
        found[cells[new]] = times[first[new]]


class LastTimeWatcher(Watcher):
    """Keeps the last time at a value."""

    def __init__(self, scene: Scene, last_time: LastTime) -> None:
        index, at = scene.state(last_time.of), last_time.at
        self._scene = scene
        self._crossings = Crossings(scene, lambda u, c: u[index] - at, "both", 0, _END)

    def see(self, chunk: Chunk) -> None:
        """Mark the crossings of a chunk."""
        self._crossings.mark(chunk)

    def settle(self) -> None:
        """Keep the last crossing of each cell; a later call knows later ones."""
        cells, times, _ = self._crossings.take()
        last = np.append(cells[1:] != cells[:-1], cells.size > 0)[: cells.size]
        self._scene.evidence["last_time"][cells[last]] = times[last]


_END = 2**62  # a window that the run ends


def make_watchers(measures: Measures, scene: Scene) -> list[Watcher]:
    """Return a watcher for each dense measure."""
    watchers: list[Watcher] = []
    for measure in measures.chosen.values():
        if isinstance(measure, Orbit):
            watchers.append(_orbit_strobe(scene, measure))
        elif isinstance(measure, Samples):
            every = measure.every
            watchers.append(SampleWatcher(scene, measure) if every is None else _sample_strobe(scene, measure, every))
        elif isinstance(measure, Peak):
            watchers.append(PeakWatcher(scene, measure))
        elif isinstance(measure, FirstTime):
            watchers.append(FirstTimeWatcher(scene, measure))
        elif isinstance(measure, LastTime):
            watchers.append(LastTimeWatcher(scene, measure))
    return watchers


def _orbit_strobe(scene: Scene, orbit: Orbit) -> Strobe:
    def write(cells: np.ndarray, due: range, u: np.ndarray) -> None:
        scene.evidence["orbit"][cells, due.start : due.stop] = u

    return Strobe(orbit.steps(scene.clock), write)


def _sample_strobe(scene: Scene, samples: Samples, every: float) -> Strobe:
    clock = scene.clock
    steps = range(clock.transient_steps, clock.steps + 1, clock.steps_of(every))

    def write(cells: np.ndarray, due: range, u: np.ndarray) -> None:
        kept = slice(due.start, min(due.stop, samples.max))
        scene.evidence["samples"][cells, kept] = u[:, : max(0, kept.stop - kept.start)]
        scene.evidence["sample_time"][cells, kept] = np.asarray(steps[kept]) * clock.dt
        scene.evidence["sample_count"][cells] = due.stop

    return Strobe(steps, write)
