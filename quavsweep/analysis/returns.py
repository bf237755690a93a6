"""Returns to a section: hits in a recorded stretch, and after how many of them an orbit nearly repeats itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quavsweep.analysis.equilibrium import vector_field
from quavsweep.analysis.event import Event, crossings, slope
from quavsweep.kernels.program import Program
from quavsweep.models import Model

MOST_HITS = 64  # the last hits of a stretch that are compared, so no cycle of more hits is found
NEAR = 5e-4  # distance of two hits, in units of the orbit's amplitude, at which they may be one point of a cycle
SETTLING = 1.2  # how much farther than the return a period before one may be
WITNESSES = 3  # last hits that must have come nearer
NOISE = 1e-5  # of returns, because hits are interpolated
LIKE = 4.0  # returns within this factor of the nearest one count as good as it, so that the first of them is the period
ROUNDING = 1e-9  # hits nearer than this are one; the least amplitude against 1 + |u|


@dataclass(frozen=True)
class Hits:
    """The last hits of n cells, the last one first.

    Parameters
    ----------
    count : (n,) int
        How many hits there are, at most K.
    time : (n, K) float64
        From the start of the stretch; NaN where there is none.
    state : (n, K, D) float64
        NaN where there is none.
    begin : (n, K, D) float64
        The states from which the steps began that hit.
    """

    count: np.ndarray
    time: np.ndarray
    state: np.ndarray
    begin: np.ndarray

    def take(self, cells: np.ndarray) -> Hits:
        """Return the hits of some cells."""
        return Hits(self.count[cells], self.time[cells], self.state[cells], self.begin[cells])


class HitList:
    """Hits that are found in parts."""

    def __init__(self, dimension: int) -> None:
        self._parts = [(np.zeros(0, dtype=int), np.zeros(0), np.zeros((0, 2 * dimension)))]

    def add(self, cells: np.ndarray, times: np.ndarray, states: np.ndarray, begin: np.ndarray) -> None:
        """Add k hits in any order: cells and times, (k,), states and those at the beginning of the step, (k, D)."""
        self._parts.append((cells, times, np.concatenate([states, begin], axis=1)))

    def table(self, n: int) -> Hits:
        """Return the table of the last hits of n cells."""
        cells, times, states = (np.concatenate(part) for part in zip(*self._parts, strict=True))
        order = np.lexsort((times, cells))
        cells = cells[order]
        total = np.bincount(cells, minlength=n)
        rank = np.cumsum(total)[cells] - 1 - np.arange(cells.size)
        kept = order[rank < MOST_HITS]
        cells, rank = cells[rank < MOST_HITS], rank[rank < MOST_HITS]
        most = max(1, int(rank.max(initial=0)) + 1)
        time, state = np.full((n, most), np.nan), np.full((n, most, states.shape[1]), np.nan)
        time[cells, rank], state[cells, rank] = times[kept], states[kept]
        return Hits(np.minimum(total, MOST_HITS), time, *np.split(state, 2, axis=2))


def section_of(model: Model, program: Program) -> tuple[Event, str]:
    """Return the event and the direction of a model's section; maxima of the first state unless it has its own."""
    section = model.section
    index = model.state_names.index(section.of) if section else 0
    if section is None or section.at is None:
        return slope(program, index), "down"
    at, circle = section.at, model.states[index].circle
    rate = 2 * np.pi / circle if circle else 0.0

    def event(u: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        # An angle is at its value once a turn, and half a turn away it crosses zero against the direction.
        return np.asarray(np.sin(rate * (u[index] - at)) / rate if rate else u[index] - at)

    return event, section.direction


def circles(model: Model) -> np.ndarray:
    """Return the length of a turn of each state, (D,), infinite where it is no angle."""
    return np.array([state.circle or np.inf for state in model.states])


def shortest(difference: np.ndarray, circle: np.ndarray) -> np.ndarray:
    """Return differences (..., D) of states, angles the short way round."""
    turns = np.where(np.isfinite(circle), np.rint(difference / circle), 0.0)
    return np.asarray(difference - turns * np.where(np.isfinite(circle), circle, 0.0))


def size(difference: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Return the largest component of differences (..., D) in units of amplitudes that broadcast with them."""
    return np.asarray(np.abs(difference / amplitude).max(axis=-1))


def amplitudes(u: np.ndarray, circle: np.ndarray) -> np.ndarray:
    """Return how far states (steps, D, n) go, (n, D): an angle at most one turn, and nothing less than rounding."""
    span = (u.max(axis=0) - u.min(axis=0)).T
    return np.asarray(np.maximum(np.minimum(span, circle), ROUNDING * (1.0 + np.abs(u[-1].T))))


def crossed(event: Event, direction: str, u: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the steps of a stretch in which cells cross a section, and the cells, by cell and step.

    Parameters
    ----------
    u : (1 + steps, D, n) float64
    coefficients : (C, n) float64
    """
    value = event(u.transpose(1, 0, 2), coefficients[:, None, :])
    steps, cells = np.nonzero(crossings(value[:-1], value[1:], direction))
    order = np.lexsort((steps, cells))
    return steps[order], cells[order]


def between(
    program: Program,
    event: Event,
    u: tuple[np.ndarray, np.ndarray],
    coefficients: np.ndarray,
    dt: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return about when and where an event happens between two states a step apart, by Hermite's polynomial.

    It takes the first two derivatives at both ends, so it is good to the sixth power of the step;
    `quavsweep.analysis.event.locate` is exact, and several times dearer.

    Parameters
    ----------
    u : pair of (n, D) float64
    coefficients : (C, n) float64
    dt : (n,) float64

    Returns
    -------
    time : (n,) float64
        From the start of the step.
    state : (n, D) float64
    """
    (before, after), h = u, dt[:, None]
    ends = []
    for x in u:
        velocity, jacobian = vector_field(program, x, coefficients)
        ends.append((x, h * velocity, 0.5 * h**2 * np.matmul(jacobian, velocity[:, :, None])[:, :, 0]))
    (x, v, a), (y, w, b) = ends
    # In powers of the share s of the step: x + v s + a s^2 + s^3 (first + second s + third s^2).
    gap, slope_, bend = y - x - v - a, w - v - 2 * a, b - a
    first = 10 * gap - 4 * slope_ + bend
    second = -15 * gap + 7 * slope_ - 2 * bend
    third = 6 * gap - 3 * slope_ + bend
    low, high = np.zeros(len(dt)), np.ones(len(dt))
    at_low, at_high = event(before.T, coefficients), event(after.T, coefficients)
    share, state = high, after
    for _ in range(6):  # regula falsi, in Illinois' form
        rise = at_high - at_low
        share = np.where(rise == 0, high, low - (high - low) * at_low / np.where(rise == 0, 1.0, rise))
        s = share[:, None]
        state = x + s * (v + s * (a + s * (first + s * (second + s * third))))
        value = event(state.T, coefficients)
        opposite = value * at_high <= 0
        low, at_low = np.where(opposite, high, low), np.where(opposite, at_high, 0.5 * at_low)
        high, at_high = share, value
    return share * dt, state


def strobed(states: np.ndarray, every: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the steps at phase 0 and the cells, from states (steps, D, m) and the steps in a period, (m,) int."""
    at, column = np.nonzero(np.arange(len(states))[:, None] % every == 0)
    return at, column


def nearest_return(hits: Hits, amplitude: np.ndarray, circle: np.ndarray) -> np.ndarray:
    """Return after how many hits an orbit nearly comes back to its last one, (n,) int; 0 where it does not.

    A return counts if it is near, and not farther than the one a period before, which tells it from most chance
    returns of chaotic orbits; so two periods are needed. Of these the first is taken that is about as near as the
    nearest: for an orbit that settles on a cycle that is one period.
    """
    states = hits.state
    distance = size(shortest(states[:, 1:] - states[:, :1], circle), amplitude[:, None, :])
    distance = np.where(distance <= NEAR, distance, np.inf)
    cells, column = np.nonzero(np.isfinite(distance))
    settles = _settles(states[cells], column + 1, amplitude[cells], circle)
    distance[cells[~settles], column[~settles]] = np.inf
    least = distance.min(axis=1, initial=np.inf)
    first = np.cumsum(distance <= np.maximum(LIKE * least, NOISE)[:, None], axis=1) == 0
    return np.where(np.isfinite(least), first.sum(axis=1) + 1, 0)


def _settles(states: np.ndarray, count: np.ndarray, amplitude: np.ndarray, circle: np.ndarray) -> np.ndarray:
    """Return whether returns after `count` hits, (k,) int, come nearer from period to period, at the last few hits."""
    rows, last = np.arange(len(count)), states.shape[1] - 1
    good = 2 * count <= last
    for first in range(WITNESSES):
        places = [np.minimum(first + periods * count, last) for periods in (0, 1, 2)]
        hits = [states[rows, place] for place in places]
        late, early = (size(shortest(hits[i + 1] - hits[i], circle), amplitude) for i in (0, 1))
        good &= (late <= np.maximum(SETTLING * early, NOISE)) | (first + 2 * count > last) | ~np.isfinite(early)
        if first == 0:
            good &= np.isfinite(early)
    return np.asarray(good)
