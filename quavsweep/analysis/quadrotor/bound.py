r"""Bounds of the energy in yaw manoeuvres: the ellipsoid of zero power (24), Theorem 1 (25), and the true maximum.

With :math:`\sigma = d (c^2 + 2 c \Omega_1)`, half the torque of the rotors, and :math:`s = \sigma / k_6`, the Casimir
power (20) is :math:`\dot C = 2 \sigma r - k_4 p^2 - k_5 q^2 - k_6 r^2`. It vanishes on an ellipsoid about (0, 0, s)
through the origin and the equilibrium E1 = (0, 0, 2 s), is positive inside and negative outside. So where C exceeds its
maximum on that ellipsoid, C falls: all orbits end in the ellipsoid C <= max C, and none leaves it.

The maximum. Given r, the powers :math:`k_4 p^2` and :math:`k_5 q^2` share :math:`2 \sigma r - k_6 r^2 \ge 0`, and C is
linear in them; so the one with the larger ratio of inertia to drag takes all. With a = k6 max(Ix / k4, Iy / k5),

.. math:: C = a s r - (a - I_z) r^2 / 2, \quad 0 \le r / s \le 2.

If a <= 2 Iz it rises up to E1, r = 2 s, where C = 2 Iz s^2: Theorem 1. Else it is largest at r = a s / (a - Iz), within
the range, where C = a^2 s^2 / (2 (a - Iz)), which is more. The theorem's proof divides the first two of equations (29)
by p and q, and so loses the points where lambda = -Ix / (2 k4) or -Iy / (2 k5).

The bound is sharp where the theorem holds and E1 is a saddle, for then E1 belongs to the closure of what starts near
it. A single attractor lies deeper, as a rule.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

Values = Mapping[str, float | np.ndarray]  # parameters by name, in the model's units; arrays of one shape, or numbers


@dataclass(frozen=True)
class Ellipsoid:
    """The ellipsoid sum of weight (u - centre)^2 = level in the space of p, q, r.

    Parameters
    ----------
    weights : (3,) float64
    centre : (3,) float64
        [rad/s].
    level : float
        In the unit of the weights times rad2/s2.
    """

    weights: np.ndarray
    centre: np.ndarray
    level: float

    @property
    def semi_axes(self) -> np.ndarray:
        """Half the lengths of its axes, (3,) [rad/s]."""
        return np.asarray(np.sqrt(self.level / self.weights))

    def surface(self, rows: int, columns: int) -> np.ndarray:
        """Return points on it along meridians and parallels, (rows, columns, 3) [rad/s]; the poles lie along r."""
        polar, azimuth = np.meshgrid(np.linspace(0, np.pi, rows), np.linspace(0, 2 * np.pi, columns), indexing="ij")
        unit = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1)
        return np.asarray(self.centre + self.semi_axes * unit)

    def value(self, u: np.ndarray) -> np.ndarray:
        """Return the left side less the level at states (..., 3): negative inside, zero on it, positive outside."""
        return np.asarray(((u - self.centre) ** 2 * self.weights).sum(axis=-1) - self.level)


@dataclass(frozen=True)
class Maximum:
    """The largest Casimir energy on the ellipsoid of zero power.

    Parameters
    ----------
    energy : (...) float64
        [J].
    at : (..., 3) float64
        A state in which it is taken [rad/s]; another one has p, q of the opposite sign.
    """

    energy: np.ndarray
    at: np.ndarray


def zero_power_ellipsoid(parameters: Values) -> Ellipsoid:
    r"""Return equation (24), :math:`k_4 p^2 + k_5 q^2 + k_6 (r - \sigma / k_6)^2 = \sigma^2 / k_6`.

    The printed right side has lost a bracket: it is :math:`d^2 (c^2 + 2 c \Omega_1)^2 / k_6`.
    """
    k4, k5, k6 = (float(parameters[name]) for name in ("k4", "k5", "k6"))
    sigma = float(_sigma(parameters))
    return Ellipsoid(np.array([k4, k5, k6]), np.array([0.0, 0.0, sigma / k6]), sigma**2 / k6)


def energy_ellipsoid(parameters: Values, energy: float) -> Ellipsoid:
    """Return the states with one Casimir energy [J]: Ix p^2 + Iy q^2 + Iz r^2 = 2 C."""
    inertia = np.array([float(parameters[name]) for name in ("Ix", "Iy", "Iz")])
    return Ellipsoid(inertia, np.zeros(3), 2.0 * energy)


def theorem_1_energy(parameters: Values) -> np.ndarray:
    """Return the largest Casimir energy by Theorem 1, 2 Iz s^2 [J], (...): half the right side of (25).

    Holds or not, it is the energy of the equilibrium E1.
    """
    return np.asarray(2.0 * parameters["Iz"] * (_sigma(parameters) / parameters["k6"]) ** 2)


def theorem_1_holds(parameters: Values) -> np.ndarray:
    """Return whether E1 has the largest energy of all states of zero power, (...) bool.

    It has if and only if Ix / k4 <= 2 Iz / k6 and Iy / k5 <= 2 Iz / k6.
    """
    return np.asarray(np.maximum(*_shares(parameters)) <= 2.0 * parameters["Iz"])


def stationary_points(parameters: Values) -> np.ndarray:
    """Return how many solutions equations (29) have, (...) int: the origin, E1, and pairs.

    One with q = 0, lambda = -Ix / (2 k4) where Ix / k4 > 2 Iz / k6; one with p = 0, lambda = -Iy / (2 k5) likewise.
    """
    return np.asarray(2 + sum(2 * (share > 2.0 * parameters["Iz"]) for share in _shares(parameters)))


def largest_energy(parameters: Values) -> Maximum:
    """Return the maximum of the Casimir energy on the ellipsoid of zero power, for any parameters.

    Parameters
    ----------
    parameters : mapping
        Omega1, c, Ix, Iy, Iz, d, k4, k5, k6 [model units], (...) each.
    """
    along_p, along_q = _shares(parameters)
    a, iz = np.maximum(along_p, along_q), parameters["Iz"]
    s = _sigma(parameters) / parameters["k6"]
    with np.errstate(divide="ignore"):
        r = np.where(a > 2.0 * iz, a * s / (a - iz), 2.0 * s)
    left = np.maximum(2.0 * s * r - r**2, 0.0)  # of the power, over k6
    p = np.where(along_p >= along_q, np.sqrt(left * parameters["k6"] / parameters["k4"]), 0.0)
    q = np.where(along_p >= along_q, 0.0, np.sqrt(left * parameters["k6"] / parameters["k5"]))
    return Maximum(np.asarray(a * s * r - 0.5 * (a - iz) * r**2), np.stack([p, q, np.asarray(r)], axis=-1))


def _sigma(parameters: Values) -> np.ndarray:
    """Return half the torque of the rotors about z [N m], (...)."""
    c, speed = parameters["c"], parameters["Omega1"]
    return np.asarray(parameters["d"] * (c**2 + 2.0 * c * speed))


def _shares(parameters: Values) -> tuple[np.ndarray, np.ndarray]:
    """Return k6 Ix / k4 and k6 Iy / k5 [kg m2], (...) each: what power is worth in p or q, to compare with Iz."""
    k6 = parameters["k6"]
    return np.asarray(k6 * parameters["Ix"] / parameters["k4"]), np.asarray(k6 * parameters["Iy"] / parameters["k5"])
