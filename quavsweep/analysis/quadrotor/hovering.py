"""Hovering: the rotor speeds at which the thrust carries the weight, conditions (21) and (22) of the paper.

In a yaw manoeuvre the front and rear rotors turn at Omega1, the left and right ones at Omega1 + c, so the thrust is
F_T = 2 b (Omega1^2 + (Omega1 + c)^2). With s = m g / (2 b), hovering is Omega1^2 + (Omega1 + c)^2 = s.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def thrust(Omega1: Any, c: Any, b: float) -> Any:  # noqa: N803 (as in the paper)
    """Return the thrust F_T [N] of rotor speeds [rad/s], with the lift coefficient b [N s2/rad2]."""
    return 2.0 * b * (np.square(Omega1) + np.square(Omega1 + c))


def hovering_speed(c: Any, m: float, g: float, b: float) -> np.ndarray:
    """Return the speed Omega1 of the front rotors [rad/s] at which the craft hovers.

    Parameters
    ----------
    c : (...) float64
        Difference of speeds [rad/s].
    m, g, b : float
        Mass [kg], acceleration of gravity [m/s2], lift coefficient [N s2/rad2].

    Returns
    -------
    (...) float64
        The root (sqrt(2 s - c^2) - c) / 2 of (22); NaN where it is below zero or not real.
    """
    c, s = np.asarray(c, dtype=np.float64), m * g / (2.0 * b)
    with np.errstate(invalid="ignore"):
        speed = 0.5 * (np.sqrt(2.0 * s - c * c) - c)
        return np.asarray(np.where(speed >= 0.0, speed, np.nan))


def hovering_difference(Omega1: Any, m: float, g: float, b: float) -> np.ndarray:  # noqa: N803
    """Return the difference c [rad/s] with which the craft hovers at a speed of the front rotors; NaN without any."""
    speed, s = np.asarray(Omega1, dtype=np.float64), m * g / (2.0 * b)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(s - speed * speed) - speed)


def hovering_stretch(
    differences: tuple[float, float], speeds: tuple[float, float], m: float, g: float, b: float
) -> tuple[float, float] | None:
    """Return from which to which c [rad/s] the craft hovers within a window of c and Omega1; None if nowhere.

    Omega1 falls along the curve while c rises.
    """
    low, high = differences
    slowest, fastest = (float(hovering_difference(speed, m, g, b)) for speed in speeds)
    low = low if np.isnan(fastest) else max(low, fastest)
    if np.isnan(slowest):
        return None
    high = min(high, slowest)
    return (low, high) if low <= high else None
