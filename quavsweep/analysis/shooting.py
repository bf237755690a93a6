"""Closing cycles by Newton's method: point and period together, with the derivative over a period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from quavsweep.analysis.equilibrium import norm, solve, vector_field
from quavsweep.analysis.event import Event
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.kink import tangent_across
from quavsweep.analysis.returns import shortest, size
from quavsweep.kernels.method import METHODS, ButcherTable

METHOD = METHODS["dp8"]
GRADES = tuple(round(8 * 2 ** (k / 4)) for k in range(96))  # numbers of steps; a cell's own period chooses one
ITERATIONS = 8
COARSE, FINE = 1e-4, 1e-10  # size of Newton's last step against the amplitude, with long steps and with short ones
FARTHEST = 0.3  # a step of Newton's method beyond this many amplitudes means that no cycle is near
LOOSEST = 0.1  # change of the period against its first guess beyond which it is another cycle
NEUTRAL = 1e-10  # wanted of the neutral exponent, 1/time
ACCEPTED = 1e-8  # of the neutral exponent, where no halving of the step brings it lower
HALVINGS = 3
UNSTABLE = 1.05  # size of a multiplier that no halving brings back to 1
GAIN = 100.0  # by which a halving of the step makes errors smaller, at least


@dataclass(frozen=True)
class Closed:
    """Orbits that close.

    Parameters
    ----------
    found : (n,) bool
    point : (n, D) float64
    period : (n,) float64
    derivative : (n, D, D) float64
        Of the state after a period by the state at the point.
    volume : (n,) float64
        Integral of the divergence over a period.
    velocity : (n, D) float64
        The derivative of the state at the point.
    error : (n,) float64
        Estimate, the larger of two: what the last halving of the step moved the point by, in amplitudes, over `GAIN`;
        and in autonomous systems, how far the derivative is from leaving the velocity as it is, relative.
    steps : (n,) int
        Steps of a period that were needed.
    """

    found: np.ndarray
    point: np.ndarray
    period: np.ndarray
    derivative: np.ndarray
    volume: np.ndarray
    velocity: np.ndarray
    error: np.ndarray
    steps: np.ndarray

    @classmethod
    def none(cls, n: int, dimension: int) -> Closed:
        """Return n orbits that are not closed."""

        def nan(*shape: int) -> np.ndarray:
            return np.full((n, *shape), np.nan)

        d = dimension
        return cls(np.zeros(n, dtype=bool), nan(d), nan(), nan(d, d), nan(), nan(d), nan(), np.zeros(n, dtype=int))

    def put(self, cells: np.ndarray, other: Closed) -> None:
        """Write other orbits into some of these."""
        for field in fields(self):
            getattr(self, field.name)[cells] = getattr(other, field.name)

    def take(self, cells: np.ndarray) -> Closed:
        """Return some of these orbits."""
        return Closed(*(getattr(self, field.name)[cells] for field in fields(self)))


def grade(steps: np.ndarray) -> np.ndarray:
    """Return the next number of steps of `GRADES` not below, (n,) int, so that cells share calls of a kernel."""
    return np.asarray(GRADES)[np.minimum(np.searchsorted(GRADES, steps), len(GRADES) - 1)]


@dataclass(frozen=True)
class Shooting:
    """Closes orbits of one program.

    Parameters
    ----------
    flow : Flow
    circle : (D,) float64
        Turns of angles, infinite for other states.
    event : callable or None
        What is zero on the section, which fixes the phase. None: the system is forced.
    index : int
        The state that the section is of.
    turning : bool
        Whether the event is that this state turns; else that it has a value.
    step : float
        The longest step [time unit of the model].
    """

    flow: Flow
    circle: np.ndarray
    event: Event | None
    index: int
    turning: bool
    step: float

    def close(
        self,
        u: np.ndarray,
        period: np.ndarray,
        parameters: Sequence[np.ndarray],
        amplitude: np.ndarray,
        multiple: np.ndarray,
        to_be_stable: bool = False,
    ) -> Closed:
        """Return the closed orbits near points of a section.

        First with long steps, then with halves of them until all is exact.

        Parameters
        ----------
        u : (n, D) float64
            Points on the section, or at phase 0.
        period : (n,) float64
            Guesses; of forced systems the period itself.
        amplitude : (n, D) float64
            Sizes of the states' motion, in units of which errors are measured.
        multiple : (n,) int
            Of which the number of steps has to be a multiple.
        to_be_stable : bool
            Whether clearly unstable orbits may be left as they are with long steps.
        """
        steps = grade(period / (self.step * multiple)) * multiple
        closed = self._newton(u, period, parameters, amplitude, steps, COARSE)
        refined = closed.found.copy()
        if to_be_stable:
            refined &= ~_unstable(closed, self.event is not None)
        open_ = np.flatnonzero(refined)
        closed.found[open_] = False
        for halving in range(1, HALVINGS + 1):
            if not open_.size:
                break
            own, start = [p[open_] for p in parameters], closed.take(open_)
            finer = self._newton(start.point, start.period, own, amplitude[open_], steps[open_] * 2**halving, FINE)
            goal = np.minimum(NEUTRAL * finer.period, NEUTRAL)
            accepted = np.minimum(ACCEPTED * finer.period, ACCEPTED)
            closed.put(open_, finer)
            closed.found[open_] &= finer.error <= accepted
            open_ = open_[finer.found & ~(finer.error <= goal)]
        return closed

    def close_as(
        self,
        method: ButcherTable,
        closed: Closed,
        parameters: Sequence[np.ndarray],
        amplitude: np.ndarray,
        steps: np.ndarray,
    ) -> Closed:
        """Return the orbits that close for a method of any order in so many steps, (n,) int, near some that close."""
        return self._newton(closed.point, closed.period, parameters, amplitude, steps, FINE, method)

    def _newton(
        self,
        u: np.ndarray,
        period: np.ndarray,
        parameters: Sequence[np.ndarray],
        amplitude: np.ndarray,
        steps: np.ndarray,
        goal: float,
        method: ButcherTable = METHOD,
    ) -> Closed:
        """Close orbits with so many steps each, until Newton's steps are as small as `goal` amplitudes."""
        guess = period
        closed = Closed.none(*u.shape)
        closed.point[:], closed.period[:], closed.steps[:] = u, period, steps
        coefficients = self.flow.program.coefficient_values(parameters)
        open_, shifted = np.arange(len(u)), np.zeros(len(u))
        for iteration in range(ITERATIONS):
            if not open_.size:
                break
            x, time, c = closed.point[open_], closed.period[open_], coefficients[:, open_]
            own = [p[open_] for p in parameters]
            end, derivative, volume = self._run(x, own, time, steps[open_], method)
            gap = shortest(end - x, self.circle)
            if self.event is None:
                velocity = np.zeros_like(x)
                change, later = solve(_table(derivative, -gap)).T, np.zeros(len(x))
            else:
                change, later, velocity = self._bordered(self.event, x, end, gap, derivative, c)
            moved = size(change, amplitude[open_])
            closed.derivative[open_], closed.volume[open_], closed.velocity[open_] = derivative, volume, velocity
            if iteration == 0:
                closed.error[open_] = shifted[open_] = moved / GAIN
            if self.event is not None:
                scaled = velocity / amplitude[open_]
                kept = np.matmul(derivative, velocity[:, :, None])[:, :, 0] / amplitude[open_]
                closed.error[open_] = np.maximum(shifted[open_], norm(kept - scaled) / norm(scaled))
            closed.point[open_] = x + change
            closed.period[open_] = time + later
            near = (moved <= FARTHEST) & (np.abs(closed.period[open_] - guess[open_]) <= LOOSEST * guess[open_])
            done = near & (moved <= goal) & (np.abs(later) <= goal * time)
            closed.found[open_[done]] = True
            open_ = open_[near & ~done]
        return closed

    def _run(
        self,
        u: np.ndarray,
        parameters: Sequence[np.ndarray],
        time: np.ndarray,
        steps: np.ndarray,
        method: ButcherTable,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if self.flow.program.switches and self.event is not None:
            return tangent_across(self.flow, method, u, parameters, time, steps)
        return self.flow.tangent(method, u, parameters, time, steps)

    def _bordered(
        self,
        event: Event,
        x: np.ndarray,
        end: np.ndarray,
        gap: np.ndarray,
        derivative: np.ndarray,
        coefficients: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return Newton's step of point and period with the point held on the section, and the velocity there."""
        n, dimension = x.shape
        velocity, jacobian = vector_field(self.flow.program, x, coefficients)
        arrival = vector_field(self.flow.program, end, coefficients)[0]
        table = np.zeros((dimension + 1, dimension + 2, n))
        table[:-1, :-2] = (derivative - np.eye(dimension)).transpose(1, 2, 0)
        table[:-1, -2], table[:-1, -1] = arrival.T, -gap.T
        table[-1, :-2] = jacobian[:, self.index].T if self.turning else np.eye(dimension)[self.index, :, None]
        table[-1, -1] = -event(x.T, coefficients)
        answer = solve(table).T
        return answer[:, :-1], answer[:, -1], velocity


def _unstable(closed: Closed, autonomous: bool) -> np.ndarray:
    """Return which orbits have a multiplier well outside the unit circle, (n,) bool, or do not close."""
    values = np.linalg.eigvals(np.where(closed.found[:, None, None], closed.derivative, 0.0))
    if autonomous:
        neutral = np.argmin(np.abs(values - 1.0), axis=1)
        values[np.arange(len(values)), neutral] = 0.0
    return np.asarray(~closed.found | (np.abs(values).max(axis=1) > UNSTABLE))


def _table(derivative: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the equations (M - I) x = right as `solve` takes them, (D, D + 1, n)."""
    matrix = derivative - np.eye(derivative.shape[-1])
    return np.concatenate([matrix, right[:, :, None]], axis=2).transpose(1, 2, 0).copy()
