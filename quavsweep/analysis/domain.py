"""Orbits that leave the domain of their equations: seen at every step, dropped at the next look."""

from __future__ import annotations

import numpy as np

from quavsweep.analysis.scene import Chunk, Scene, Watcher
from quavsweep.codes import Status
from quavsweep.measures import BASE


class DomainWatcher(Watcher):
    """Knows of each cell the last step at which all states lay in the domain, once one of them does not.

    It comes before all other watchers and hides from them what lies behind: those states are NaN.
    """

    def __init__(self, scene: Scene) -> None:
        n = len(scene.evidence["cell"])
        self._scene = scene
        self._step = np.full(n, -1, dtype=np.int64)
        self._state = np.full((n, len(scene.model.states)), np.nan)

    def see(self, chunk: Chunk) -> None:
        """Find the cells that leave, on the border or beyond, also those that come back later."""
        model, u = self._scene.model, chunk.u
        chunk.u[:, :, self._step[chunk.cells] >= 0] = np.nan
        outside = ~model.inside(u.transpose(1, 0, 2))
        row = np.maximum(outside.argmax(axis=0) - 1, 0)
        column = np.flatnonzero(outside.any(axis=0) & (self._step[chunk.cells] < 0))
        last = u[row[column], :, column]
        column, last = column[bounded := model.bounded(last)], last[bounded]  # others diverge
        self._step[chunk.cells[column]] = chunk.first + row[column]
        self._state[chunk.cells[column]] = last
        hidden = np.zeros_like(outside)
        hidden[:, column] = np.arange(len(u))[:, None] > row[column]
        chunk.u.transpose(0, 2, 1)[hidden] = np.nan

    def left(self, cells: np.ndarray) -> np.ndarray:
        """Return which cells have left, (m,) bool."""
        return np.asarray(self._step[cells] >= 0)

    def write(self, cells: np.ndarray) -> np.ndarray:
        """Write into the evidence of cells that left how they ended; return the steps until which they are known.

        Their last state is that in the domain. Nothing is certain of their end, whatever was thought so before.
        """
        evidence = self._scene.evidence
        for variable in BASE:
            if variable.name != "cell":
                evidence[variable.name][cells] = variable.fill
        evidence["status"][cells] = Status.LEFT_DOMAIN
        evidence["steps"][cells] = self._step[cells]
        evidence["state"][cells] = self._state[cells]
        return np.asarray(self._step[cells])
