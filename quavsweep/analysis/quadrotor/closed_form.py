"""Equilibria of the yaw system (15) in closed form, their bifurcations, and why there are no others.

With A = Iy - Iz, C = Iz - Ix, E = Ix - Iy, B = 2 c Ir and T = 2 d (c^2 + 2 c Omega1) the equilibria solve

    (A r - B) q = k4 p,    (C r + B) p = k5 q,    E p q = k6 r - T.

Either p = q = 0 and r = T / k6, which is E1, or (A r - B) (C r + B) = k4 k5: two values of r that do not depend on
Omega1. To each belong p = sigma q with sigma = (A r - B) / k4 and q^2 = (k6 r - T) (C r + B) / (E k5), so two
equilibria that the symmetry maps onto each other if that is positive. These are equations (17), (18) of the paper,
with a2^2 the discriminant, a13^2 the q^2 of E2 and E3, a14^2 that of E4 and E5; a5 lacks a factor of 2 in the text.

At such a pair the characteristic polynomial is l^3 + a l^2 + b l + e. With x = k4/Ix, y = k5/Iy, z = k6/Iz

    a = x + y + z,    b = z (x + y) + b1 Q,    e = e1 Q,    Q = q^2,
    a b - e = a z (x + y) - E (A Iy (x - y + z) + C Ix sigma^2 (y + z - x)) Q / (Ix Iy Iz),

linear in Q, so by Routh and Hurwitz a Hopf bifurcation is where the last line is zero, and there is none if the
factor of Q is not negative. At E1 the sum of the two eigenvalues that bend is -(x + y) < 0: no Hopf bifurcation ever.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from quavsweep.analysis.interval import Interval

Parameters = Mapping[str, Any]  # of `quadrotor_yaw` by name: floats, arrays that broadcast, or intervals
NAMES = ("E1", "E2", "E3", "E4", "E5")  # as in equations (17)


@dataclass(frozen=True)
class Pair:
    """Two equilibria (sigma q, q, r) and (-sigma q, -q, r), where q^2 is positive.

    Parameters
    ----------
    r : float or array [rad/s]
    sigma : float or array
        p / q.
    q_squared : float or array [rad2/s2]
        Negative or NaN where there are none.
    """

    r: Any
    sigma: Any
    q_squared: Any

    def states(self, sign: int) -> np.ndarray:
        """Return one of the two, (..., 3) float64, NaN where there is none; a sign of 1 is that with q > 0."""
        with np.errstate(invalid="ignore"):
            q = sign * np.sqrt(np.where(np.asarray(self.q_squared) > 0, self.q_squared, np.nan))
        return np.stack(np.broadcast_arrays(self.sigma * q, q, np.where(np.isnan(q), np.nan, self.r)), axis=-1)


def resting_rate(parameters: Parameters) -> Any:
    """Return r of E1 [rad/s], a15 of equations (18): the yaw rate at which drag balances the rotors' torque."""
    k = parameters
    return 2 * k["d"] * (k["c"] * k["c"] + 2 * k["c"] * k["Omega1"]) / k["k6"]


def discriminant(parameters: Parameters) -> Any:
    """Return a2^2 of equations (18); the side equilibria have real r where it is not negative."""
    k = parameters
    a3 = (k["Ix"] - k["Iy"]) * k["Ir"] * k["c"]
    return a3 * a3 - _a1(k) * k["k4"] * k["k5"]


def pair(parameters: Parameters, sign: int) -> Pair:
    """Return the pair E2, E3 (sign 1) or E4, E5 (sign -1).

    Where Ix < Iz < Iy, as in Table 2, and c > 0, the first has r < 0 and needs T < k6 r, so it exists for no
    Omega1 >= 0; the other has r > 0 and exists for T > k6 r.
    """
    k = parameters
    with np.errstate(invalid="ignore", divide="ignore"):
        root = _root(discriminant(k))
        r = ((k["Ix"] + k["Iy"] - 2 * k["Iz"]) * k["Ir"] * k["c"] + sign * root) / _a1(k)
        twice = 2 * k["c"] * k["Ir"]
        sigma = ((k["Iy"] - k["Iz"]) * r - twice) / k["k4"]
        torque = k["k6"] * (r - resting_rate(k))
        q_squared = torque * ((k["Iz"] - k["Ix"]) * r + twice) / ((k["Ix"] - k["Iy"]) * k["k5"])
    return Pair(r, sigma, q_squared)


def closed_form_equilibria(parameters: Parameters) -> dict[str, np.ndarray]:
    """Return the equilibria by the paper's names, each (..., 3) float64 [rad/s], NaN where it does not exist."""
    rate = np.asarray(resting_rate(parameters), dtype=float)
    first, second = pair(parameters, 1), pair(parameters, -1)
    return {
        "E1": np.stack([np.zeros_like(rate), np.zeros_like(rate), rate], axis=-1),
        "E2": first.states(1),
        "E3": first.states(-1),
        "E4": second.states(1),
        "E5": second.states(-1),
    }


def sign_condition(parameters: Parameters) -> tuple[str, tuple[str, ...]]:
    """Return the row of Table 1 for one set of parameters: the signs of a2^2, a13^2, a14^2, and the equilibria."""
    if not discriminant(parameters) > 0:
        return "-", ("E1",)
    signs = [float(pair(parameters, sign).q_squared) > 0 for sign in (1, -1)]
    names = ("E1", *(NAMES[1:3] if signs[0] else ()), *(NAMES[3:5] if signs[1] else ()))
    return " ".join("+" if positive else "-" for positive in (True, *signs)), names


def pitchfork_speed(parameters: Parameters, sign: int = -1) -> Any:
    """Return Omega1 [rad/s] at which a pair leaves E1: where T = k6 r; its own value of Omega1 is not read."""
    k = parameters
    r = pair({**k, "Omega1": 0.0}, sign).r
    return (k["k6"] * r / (2 * k["d"]) - k["c"] * k["c"]) / (2 * k["c"])


def hopf_factor(parameters: Parameters, sign: int = -1) -> Any:
    """Return the factor of Q in a b - e at a pair, times Ix Iy Iz; if it is not negative there is no Hopf bifurcation.

    Where E < 0, A, C > 0, it suffices that x <= y + z and y <= x + z: rates that are the sides of a triangle.
    """
    k = parameters
    x, y, z = k["k4"] / k["Ix"], k["k5"] / k["Iy"], k["k6"] / k["Iz"]
    sigma = pair(k, sign).sigma
    roll = (k["Iy"] - k["Iz"]) * k["Iy"] * (x - y + z)
    pitch = (k["Iz"] - k["Ix"]) * k["Ix"] * (y + z - x)
    return (k["Iy"] - k["Ix"]) * (roll + pitch * sigma * sigma)


def damping_factor(parameters: Parameters, sign: int = -1) -> Any:
    """Return e / Q at a pair, times Ix Iy Iz: a pair with a negative one has an unstable direction, a saddle's."""
    k = parameters
    found = pair(k, sign)
    a, c, e = k["Iy"] - k["Iz"], k["Iz"] - k["Ix"], k["Ix"] - k["Iy"]
    return -2 * e * found.sigma * (2 * a * c * found.r + 2 * k["c"] * k["Ir"] * (a - c))


def _root(x: Any) -> Any:
    return x.sqrt() if isinstance(x, Interval) else np.sqrt(x)


def _a1(k: Parameters) -> Any:
    return (k["Ix"] - k["Iz"]) * (k["Iy"] - k["Iz"])
