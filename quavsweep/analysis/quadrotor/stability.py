"""That no bifurcation of equilibria crosses a plane of parameters: closed forms over intervals, so for every point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from quavsweep.analysis.interval import Interval
from quavsweep.analysis.quadrotor.closed_form import damping_factor, hopf_factor, pitchfork_speed

SLICES = 2000  # intervals that a range is cut into; wide ones would bound less well


@dataclass(frozen=True)
class Margins:
    """Lower bounds over a plane of what must be positive for E1 to be a saddle and E4, E5 to be stable.

    Parameters
    ----------
    speed : float
        Least Omega1 of the plane minus that of the pitchfork [rad/s].
    determinant, hopf : float
        Bounds of the closed forms `damping_factor` and `hopf_factor` against their sizes where they are largest.
    """

    speed: float
    determinant: float
    hopf: float

    @property
    def holds(self) -> bool:
        """Whether it is proved."""
        return min(self.speed, self.determinant, self.hopf) > 0


def no_bifurcation(parameters: Mapping[str, float], least_speed: float, name: str, low: float, high: float) -> Margins:
    """Return the margins over the plane of all Omega1 >= `least_speed` and a second parameter from `low` to `high`.

    The last two conditions do not depend on Omega1, and beyond the pitchfork the pair E4, E5 exists for every larger
    Omega1 (c > 0). Then all coefficients of its characteristic polynomial and a b - e are positive: by Routh and
    Hurwitz its eigenvalues lie to the left of the axis, and E1, beyond the pitchfork, has one to the right.
    """
    ends = np.linspace(low, high, SLICES + 1)
    k = {**parameters, name: Interval(ends[:-1], ends[1:])}
    speed = least_speed - pitchfork_speed(k)
    determinant, hopf = damping_factor(k), hopf_factor(k)
    return Margins(
        float(speed.low.min()),
        float(determinant.low.min() / np.abs(determinant.high).max()),
        float(hopf.low.min() / np.abs(hopf.high).max()),
    )
