"""Remark 3 as a classifier of its own: what an orbit does, by nothing but the series of its Casimir power.

The remark's six cases, made operational for a series P over the last stretch of a run:

==== ========================================= ==================================================== ===========
case the remark                                here                                                 region
==== ========================================= ==================================================== ===========
(6)  P converges to zero                       zero throughout, or its envelope falls in each       sink
                                               eighth of the stretch, to half or less in all
(3)  P < 0 for all times                       as (6), and negative throughout; or does not         sink
                                               converge, negative throughout
(2)  P is a nonzero constant                   varies by less than the tolerance and is not zero    periodic
(1)  P > 0 for all times                       positive throughout, does not converge to zero       unbounded
(4)  P oscillates periodically                 the sequence of its maxima repeats                   periodic
(5)  P is bounded, irregular around zero       changes its sign, and is none of that                chaos
==== ========================================= ==================================================== ===========

Every finite series is in exactly one of them. The remark itself does not divide orbits so:

- (2) contradicts itself: a nonzero constant "i.e. identically zero". No bounded orbit has a constant power other than
  zero, since its energy would grow or fall for ever; and a power that is zero throughout belongs to a point at rest,
  (6), as well as to a motion of constant energy. Its first half is taken by its word, its second half counts as (6).
- (3) and (6) overlap: energy is not negative, so a power that stays negative has a finite integral and tends to zero.
- (1) and (6) overlap: an orbit that climbs to a sink has a positive power for all times. Convergence is asked first.
- Quasi-periodic orbits are in no case; here they are in (5).
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from quavsweep.analysis.maxima import maxima
from quavsweep.codes import Code, Region

ZERO = 1e-12  # W: terms of 1e-3 W cancel to rounding, 1e-18 W; orbits that move have 1e-5 W and more
TOLERANCE = 0.01  # of the series' range: maxima so near are the same
PARTS = 8  # of the stretch, in each of which the envelope of what converges is lower than before
CONVERGED = 0.5  # last part against the first, at most


class Case(IntEnum):
    """A case of Remark 3."""

    NONE = 0
    POSITIVE = 1
    CONSTANT = 2
    NEGATIVE = 3
    PERIODIC = 4
    IRREGULAR = 5
    CONVERGES = 6


_ROWS = {
    Case.NONE: ("no finite series", "#ffffff", Region.UNBOUNDED),
    Case.POSITIVE: ("positive", "#000000", Region.UNBOUNDED),
    Case.CONSTANT: ("constant", "#009e73", Region.PERIODIC),
    Case.NEGATIVE: ("negative", "#56b4e9", Region.SINK),
    Case.PERIODIC: ("periodic", "#f0e442", Region.PERIODIC),
    Case.IRREGULAR: ("irregular", "#b5202e", Region.CHAOS),
    Case.CONVERGES: ("converges to zero", "#0072b2", Region.SINK),
}
CASE = tuple(
    Code(int(case), case.name.lower(), f"({int(case)}) {meaning}" if case else meaning, colour)
    for case, (meaning, colour, _) in _ROWS.items()
)
REGION_OF_CASE = np.array([int(region) for _, _, region in _ROWS.values()], dtype=np.int8)


def classify_power(
    power: np.ndarray, dt: float, zero: float = ZERO, tolerance: float = TOLERANCE
) -> tuple[np.ndarray, np.ndarray]:
    """Return the case of Remark 3 of each series of Casimir power, and the region that the remark gives it.

    Parameters
    ----------
    power : (n, times) float64
        Casimir power over the last stretch of each run, at even times [W].
    dt : float
        Time between two values [s].
    zero : float
        A power as small as this is zero [W].
    tolerance : float
        Maxima so near, as a share of the series' range, are the same; see `repeats`.

    Returns
    -------
    case : (n,) int8
        A `Case`.
    region : (n,) int8
        A `Region`.
    """
    finite = np.isfinite(power).all(axis=1)
    power = np.where(finite[:, None], power, 0.0)
    low, high = power.min(axis=1), power.max(axis=1)
    size = np.maximum(high, -low)
    still = size <= zero
    converges = still | _falls(power)
    periodic = np.zeros(len(power), bool)
    open_ = np.flatnonzero(finite & ~converges)
    periodic[open_] = repeats(power[open_], dt, tolerance) > 0
    choices = (
        (~finite, Case.NONE),
        (converges & ~still & (high < 0.0), Case.NEGATIVE),
        (converges, Case.CONVERGES),
        (high - low <= tolerance * size, Case.CONSTANT),
        (low > 0.0, Case.POSITIVE),
        (high < 0.0, Case.NEGATIVE),
        (periodic, Case.PERIODIC),
    )
    conditions, cases = zip(*choices, strict=True)
    case = np.select(conditions, [int(c) for c in cases], int(Case.IRREGULAR)).astype(np.int8)
    return case, REGION_OF_CASE[case]


def _falls(power: np.ndarray) -> np.ndarray:
    """Whether the envelope falls from part to part of the stretch, and enough in all, (n,) bool."""
    length = power.shape[1] // PARTS
    if length == 0:
        return np.zeros(len(power), bool)
    tail = np.abs(power[:, power.shape[1] - PARTS * length :])
    envelope = tail.reshape(len(power), PARTS, length).max(axis=2)
    falls = (envelope[:, 1:] < envelope[:, :-1]).all(axis=1)
    return np.asarray(falls & (envelope[:, -1] <= CONVERGED * envelope[:, 0]))


def repeats(power: np.ndarray, dt: float, tolerance: float = TOLERANCE) -> np.ndarray:
    """Return after how many maxima each series repeats, (n,) int; 0 where it does not within half of the stretch.

    Parameters
    ----------
    power : (n, times) float64
        Series at even times.
    dt : float
        Time between two values.
    tolerance : float
        Heights of maxima that differ by so much, as a share of the series' range, are the same; so are distances in
        time that differ by so much, as a share of the time in which the series repeats.

    Notes
    -----
    A series repeats after p maxima if each maximum has the height of the p-th one after it, if p maxima take the same
    time everywhere, and if there are 2 p maxima or more. Height and time of a maximum are those of the parabola through
    three values: its error falls as dt^4 in height, as dt^2 in time.
    """
    found = np.zeros(len(power), dtype=np.int64)
    scale = tolerance * np.ptp(power, axis=1)
    for i, row in enumerate(power):
        index, height = maxima(row)
        found[i] = _period(index * dt, height, scale[i], tolerance)
    return found


def _period(time: np.ndarray, height: np.ndarray, scale: float, tolerance: float) -> int:
    """Return the smallest p after which heights and times of maxima repeat, 0 if there is none."""
    for p in range(1, len(height) // 2 + 1):
        if (np.abs(height[p:] - height[:-p]) > scale).any():
            continue
        length = time[p:] - time[:-p]
        if np.ptp(length) <= tolerance * length.mean():
            return p
    return 0
