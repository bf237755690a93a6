"""Crossings of signals through values: the steps are marked chunk by chunk, the roots found together."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from quavsweep.analysis.event import Event, crossings, locate, steps_from
from quavsweep.analysis.scene import Chunk, Scene, Signal


@dataclass
class Crossings:
    """Finds where a function of the state crosses zero: marks steps at once, locates the crossings when asked.

    Parameters
    ----------
    signal : Signal
        Tells what the event takes beside the state.
    event : callable
        From states (D, ...), what is given (G, ...) and time to values.
    direction : str
        `up`, `down`, `both` or `beyond`, see `crossings`.
    first, last : int
        Steps between which crossings count.
    """

    scene: Scene
    signal: Signal
    event: Event
    direction: str
    first: int
    last: int
    _marked: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)

    def mark(self, chunk: Chunk) -> None:
        """Remember the steps of a chunk in which the event happens."""
        if chunk.last <= self.first or chunk.first >= self.last:
            return
        value = self.signal.of(chunk, self.scene, self.event)
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
        t = clock.phase(steps)
        after = steps_from(scene.program, scene.method, u, scene.coefficients[:, cells], t)
        time, state = locate(after, clock.dt, self.event, u, self.signal.given[:, cells], t)
        return cells, steps * clock.dt + time, state.T
