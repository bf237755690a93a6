"""What watchers of orbits see: the scene, chunks of states, and states and observables as signals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from quavsweep.analysis.event import Event, slope
from quavsweep.clock import Clock
from quavsweep.kernels.lookup import make_observables
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import TIME, Program, Ref
from quavsweep.measures import Evidence
from quavsweep.models import Model


@dataclass(frozen=True)
class Signal:
    """A state or observable: its value and its rate of change, as functions of the state and what is given.

    Parameters
    ----------
    value, slope : callable
        From states (D, ...), what is given (G, ...), and time to (...).
    given : (G, n) float64
        Coefficients or parameters of all cells of the tile.
    """

    value: Event
    slope: Event
    given: np.ndarray

    def of(self, chunk: Chunk, scene: Scene, event: Event, skipped: int = 0) -> np.ndarray:
        """Return what an event says of a chunk's states, without the first ones, (1 + steps, m)."""
        clock, steps = scene.clock, np.arange(chunk.first + skipped, chunk.last + 1)[:, None]
        time = (clock.phase(steps),) if clock.period_steps else ()
        return event(chunk.u[skipped:].transpose(1, 0, 2), self.given[:, None, chunk.cells], *time)


def _computed(program: Program, ref: Ref) -> Event:
    """Return a number of the observables' program as an event; it takes parameters beside the state."""

    def event(u: np.ndarray, parameters: np.ndarray, t: Any = None) -> np.ndarray:
        known = dict(zip((*program.states, *program.parameters), (*u, *parameters), strict=True))
        (value,) = program.evaluate([ref], known if t is None else {**known, TIME: t})
        return np.broadcast_to(value, u.shape[1:])

    return event


@dataclass(frozen=True)
class Scene:
    """What all watchers share: the equations, the clock, and the tile's evidence that they write into.

    Parameters
    ----------
    coefficients, parameters : (C, n) and (P, n) float64
        Of all cells of the tile.
    evidence : dict
        Arrays of all cells of the tile.
    """

    model: Model
    program: Program
    method: ButcherTable
    clock: Clock
    coefficients: np.ndarray
    parameters: np.ndarray
    evidence: Evidence

    def signal(self, name: str) -> Signal:
        """Return a state or observable as a function of the state."""
        model = self.model
        if name in model.state_names:
            index = model.state_names.index(name)
            return Signal(lambda u, c, *t: u[index], slope(self.program, index), self.coefficients)
        program, index = make_observables(model), model.observable_names.index(name)
        rate = len(model.observables) + index
        return Signal(_computed(program, program.rhs[index]), _computed(program, program.rhs[rate]), self.parameters)


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


class Watcher:
    """Serves one measure."""

    def see(self, chunk: Chunk) -> None:
        """Look at the states of a chunk."""

    def settle(self) -> None:
        """Write down what has been seen since the last call."""

    def void(self, cells: np.ndarray, known: np.ndarray) -> None:
        """Take back what means nothing for cells that broke down, and are known up to these steps only."""
