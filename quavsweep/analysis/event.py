"""Events between two steps: where a function of the state changes its sign, found with a step of a part of dt."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from quavsweep.analysis.equilibrium import Time, derivatives
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program

ITERATIONS = 12  # of the Illinois method, of order 1.44, at most
CLOSE = 1e-15  # change of the time, in steps, that ends them

# Of states (D, n), coefficients (C, n) and, in forced systems, time to (n,).
Event = Callable[..., np.ndarray]

# Of lengths of steps, (k,) float64, and the places in a list where they begin, (k,) int, to the states after, (D, k).
After = Callable[[np.ndarray, np.ndarray], np.ndarray]


def slope(program: Program, index: int) -> Event:
    """Return the event that a state turns: its derivative, downward at a maximum."""

    def event(u: np.ndarray, coefficients: np.ndarray, t: Time = None) -> np.ndarray:
        (value,) = program.evaluate([program.rhs[index]], program.names(u, coefficients, t))
        return np.broadcast_to(value, u.shape[1:])

    return event


def crossings(before: np.ndarray, after: np.ndarray, direction: str) -> np.ndarray:
    """Return where values change their sign from one to the next: upward, downward, or `both`; bool.

    A value that is zero counts with the step that reaches it, not with the one that leaves it, so no crossing is
    counted twice; an orbit that touches zero exactly there and turns back counts as well. `beyond` is a step that
    ends above zero and began at or below it.
    """
    if direction == "beyond":
        return np.asarray((before <= 0) & (after > 0))
    if direction == "both":
        return np.asarray(crossings(before, after, "up") | crossings(before, after, "down"))
    return np.asarray((before < 0) & (after >= 0) if direction == "up" else (before > 0) & (after <= 0))


def step(
    program: Program, method: ButcherTable, dt: np.ndarray, u: np.ndarray, coefficients: np.ndarray, t: Time = None
) -> np.ndarray:
    """Return the states after a step of a length of its own for each.

    Parameters
    ----------
    dt : (n,) float64
    u : (D, n) float64
    coefficients : (C, n) float64
    t : (n,) float64 or float, optional
        Time at the start of the step, needed if the system is forced.
    """
    slopes: list[np.ndarray] = []
    for row, node in zip(method.a, method.nodes, strict=True):
        shift = sum((float(a) * k for a, k in zip(row, slopes, strict=True) if a), start=np.zeros_like(u))
        slopes.append(derivatives(program, u + dt * shift, coefficients, _later(t, float(node) * dt)))
    return np.asarray(u + dt * sum((float(b) * k for b, k in zip(method.b, slopes, strict=True)), start=0.0))


def _later(t: Time, by: np.ndarray) -> Time:
    return None if t is None else t + by


def _told(t: Time, by: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return a later time as events take it: not at all where there is none."""
    return () if t is None else (t + by,)


def steps_from(
    program: Program, method: ButcherTable, u: np.ndarray, coefficients: np.ndarray, t: Time = None
) -> After:
    """Return what steps from states (D, n) end in; `Flow.steps_from` is faster where there is a compiled kernel."""

    def after(time: np.ndarray, which: np.ndarray) -> np.ndarray:
        begin = t if t is None or np.ndim(t) == 0 else np.asarray(t)[which]
        return step(program, method, time, u[:, which], coefficients[:, which], begin)

    return after


def locate(
    after: After,
    dt: float | np.ndarray,
    event: Event,
    u: np.ndarray,
    coefficients: np.ndarray,
    t: Time = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return when, and in which state, an event happens within the step that starts at `u`.

    The Illinois method on the length of the step, taken by the method itself, so that the state lies on the computed
    orbit to the method's order.

    Parameters
    ----------
    after : callable
        The method's steps from `u`, see `After`.
    dt : float or (n,) float64
        Length of the step.
    u : (D, n) float64
        States from which a whole step crosses zero.
    coefficients : (C, n) float64
    t : (n,) float64 or float, optional
        Time at the start of the step, needed if the system is forced.

    Returns
    -------
    time : (n,) float64
        From the start of the step, in (0, dt].
    state : (D, n) float64

    References
    ----------
    .. [1] M. Dowell, P. Jarratt, BIT 11, 168 (1971).
    """
    low, high = np.zeros(u.shape[1]), np.zeros(u.shape[1]) + dt
    near, state = CLOSE * high, np.empty_like(u)

    def value_after(time: np.ndarray, which: np.ndarray) -> np.ndarray:
        begin = t if t is None or np.ndim(t) == 0 else np.asarray(t)[which]
        state[:, which] = reached = after(time, which)
        return event(reached, coefficients[:, which], *_told(begin, time))

    open_ = np.arange(u.shape[1])
    at_low, at_high = np.array(event(u, coefficients, *_told(t, low))), np.array(value_after(high, open_))
    for _ in range(ITERATIONS):
        if not open_.size:
            break
        a, b, f_a, f_b = low[open_], high[open_], at_low[open_], at_high[open_]
        rise = f_b - f_a
        time = np.where(rise == 0, b, (a * f_b - b * f_a) / np.where(rise == 0, 1.0, rise))
        value = value_after(time, open_)
        opposite = value * f_b <= 0
        # An end that stays counts half from then on, so that both ends move.
        low[open_], at_low[open_] = np.where(opposite, b, a), np.where(opposite, f_b, 0.5 * f_a)
        high[open_], at_high[open_] = time, value
        open_ = open_[(np.abs(time - b) > near[open_]) & (value != 0)]
    return high, state
