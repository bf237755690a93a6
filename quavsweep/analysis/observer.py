"""What dense measures write down: states at even times, on sections and at maxima, peaks, first passages.

The observer sees the states of all steps, chunk by chunk. It marks the steps in which something happens, and finds
what it was exactly once per segment for all of them together, because a call of NumPy costs more than a few cells.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from quavsweep.analysis.crossing import Crossings
from quavsweep.analysis.scene import Chunk, Scene, Watcher
from quavsweep.analysis.statistics import StatisticsWatcher
from quavsweep.measures import FirstTime, LastTime, Measures, Orbit, Peak, Samples, Statistics


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
            signal, at = scene.signal(samples.section.of), samples.section.at
            direction = samples.section.direction
            self._crossings = Crossings(
                scene, signal, lambda u, c, *t: signal.value(u, c, *t) - at, direction, first, _END
            )
        else:
            signal = scene.signal(samples.maxima or scene.model.state_names[0])
            self._crossings = Crossings(scene, signal, signal.slope, "down", first, _END)

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
    """Keeps the value of largest magnitude: at a turn of the quantity, or at an end of the window."""

    def __init__(self, scene: Scene, peak: Peak) -> None:
        self._scene, self._last = scene, peak.hold(scene.clock)
        self._signals = [scene.signal(name) for name in peak.of]
        self._turns = [Crossings(scene, signal, signal.slope, "both", 0, self._last) for signal in self._signals]

    def see(self, chunk: Chunk) -> None:
        """Mark the turns of a chunk, and look at the ends of the window."""
        for turns in self._turns:
            turns.mark(chunk)
        for step in (0, self._last):
            if chunk.first <= step <= chunk.last:
                for column in range(len(self._signals)):
                    time = np.full(chunk.cells.size, step * self._scene.clock.dt)
                    self._offer(
                        column, chunk.cells, time, self._value(column, chunk.cells, chunk.u[step - chunk.first], time)
                    )

    def settle(self) -> None:
        """Offer the turns that were found, of each cell the largest first."""
        for column, turns in enumerate(self._turns):
            cells, times, states = turns.take()
            values = self._value(column, cells, states.T, times)
            order = np.lexsort((times, -np.abs(values), cells))
            first = order[np.unique(cells[order], return_index=True)[1]]
            self._offer(column, cells[first], times[first], values[first])

    def _value(self, column: int, cells: np.ndarray, u: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return a quantity of cells in states (D, m) at some times, (m,)."""
        signal, clock = self._signals[column], self._scene.clock
        return signal.value(u, signal.given[:, cells], *((times,) if clock.period_steps else ()))

    def void(self, cells: np.ndarray, known: np.ndarray) -> None:
        """Leave no peak where the orbit broke down before the end of the window."""
        unfinished = cells[known < self._last]
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
        self._scene, self._signal = scene, scene.signal(first_time.of)
        sign, value = (1.0 if direction == "up" else -1.0), self._signal.value
        last = first_time.hold(scene.clock)
        self._crossings = Crossings(
            scene, self._signal, lambda u, c, *t: sign * (value(u, c, *t) - limit), "beyond", 0, last
        )

    def see(self, chunk: Chunk) -> None:
        """Mark the crossings of a chunk; an orbit may begin beyond the limit."""
        self._crossings.mark(chunk)
        if chunk.first == 0:
            beyond = self._signal.of(chunk, self._scene, self._crossings.event)[0] > 0
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
        signal, at = scene.signal(last_time.of), last_time.at
        self._scene = scene
        self._crossings = Crossings(scene, signal, lambda u, c, *t: signal.value(u, c, *t) - at, "both", 0, _END)

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
        elif isinstance(measure, Statistics):
            watchers.append(StatisticsWatcher(scene, measure))
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
