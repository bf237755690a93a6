"""The quadrotor as a rigid body: torques (9) to (12), Euler kinematics (16) and forces (3) to (5) of the paper.

Vectors are tuples of their components: of torques and angular velocities in the body frame, of forces in the earth's.
The signs are those with which the torques add up to I domega/dt, equation (7): drag counts against the motion.
"""

from __future__ import annotations

from typing import Any

from quavsweep.models.function import cos, sin, tan
from quavsweep.models.model import Relation
from quavsweep.models.quantity import Observable, State, vector

RATES = (
    State("p", "rad/s", "p", "roll rate, body frame"),
    State("q", "rad/s", "q", "pitch rate, body frame"),
    State("r", "rad/s", "r", "yaw rate, body frame"),
)
NO_BODY = "no rigid body has such moments of inertia"
RELATIONS = (
    Relation("Ix <= Iy + Iz", lambda Ix, Iy, Iz: Ix <= Iy + Iz, NO_BODY),
    Relation("Iy <= Ix + Iz", lambda Ix, Iy, Iz: Iy <= Ix + Iz, NO_BODY),
    Relation("Iz <= Ix + Iy", lambda Ix, Iy, Iz: Iz <= Ix + Iy, NO_BODY),
)


def inertial_torque(p, q, r, Ix, Iy, Iz) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """-S(I omega) omega with S of (9) [N m]; it does no work."""
    return (Iy - Iz) * q * r, (Iz - Ix) * p * r, (Ix - Iy) * p * q


def gyro_torque(p, q, Omega, Ir) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Gamma_alpha of (10) [N m], of rotors that together turn at Omega = Omega2 + Omega4 - Omega1 - Omega3."""
    return -Ir * Omega * q, Ir * Omega * p, 0


def drag_torque(p, q, r, k4, k5, k6) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """-Gamma_d with Gamma_d of (11) [N m]."""
    return -k4 * p, -k5 * q, -k6 * r


def rotor_torque(Omega1, Omega2, Omega3, Omega4, b, l, d) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]  # noqa: E741
    """Gamma_f of (12) [N m]."""
    roll, pitch = b * l * (Omega4**2 - Omega2**2), b * l * (Omega3**2 - Omega1**2)
    return roll, pitch, d * (Omega4**2 + Omega2**2 - Omega3**2 - Omega1**2)


def work(p, q, r, torque) -> Any:  # type: ignore[no-untyped-def]
    """Power of a torque [W]."""
    return p * torque[0] + q * torque[1] + r * torque[2]


def casimir_energy(p, q, r, Ix, Iy, Iz) -> Any:  # type: ignore[no-untyped-def]
    """Rotational kinetic energy (19) [J]."""
    return (Ix * p**2 + Iy * q**2 + Iz * r**2) / 2


def dissipated_power(p, q, r, k4, k5, k6) -> Any:  # type: ignore[no-untyped-def]
    """Power that air drag takes, behind (20) [W]."""
    return k4 * p**2 + k5 * q**2 + k6 * r**2


def euler_rates(p, q, r, phi, theta) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Rates of roll, pitch and yaw angle by (16) [rad/s]; there are none at theta = +-pi/2."""
    level = q * sin(phi) + r * cos(phi)
    return p + level * tan(theta), q * cos(phi) - r * sin(phi), level / cos(theta)


def upward(phi, theta, psi) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Unit vector along the thrust in the earth's frame, by (3)."""
    return (
        cos(phi) * sin(theta) * cos(psi) + sin(phi) * sin(psi),
        cos(phi) * sin(theta) * sin(psi) - sin(phi) * cos(psi),
        cos(phi) * cos(theta),
    )


# Observables that ask nothing of how the rotors turn.
OBSERVABLES = (
    Observable("casimir_energy", casimir_energy, "J", "C", "Casimir energy, the rotational kinetic energy"),
    Observable("dissipated_power", dissipated_power, "W", r"P_\mathrm{dis}", "power dissipated by air drag"),
    *vector("inertial_torque_{}", inertial_torque, "N m", r"\Gamma_{{\mathrm{{in}},{}}}", "inertial torque"),
    *vector("drag_torque_{}", drag_torque, "N m", r"\Gamma_{{\mathrm{{drag}},{}}}", "dissipative torque"),
)


def driven(torque: Any, gyro: Any, rotor: Any, power: Any, supplied: Any) -> tuple[Observable, ...]:
    """Return all observables of an attitude, given the functions that depend on how the rotors turn."""
    return (
        Observable("casimir_power", power, "W", r"\dot C", "Casimir power, the rate of the Casimir energy"),
        Observable("supplied_power", supplied, "W", r"P_\mathrm{sup}", "power supplied by the rotors"),
        *OBSERVABLES,
        *vector(
            "gyro_torque_{}", gyro, "N m", r"\Gamma_{{\mathrm{{gyro}},{}}}", "internal torque, the gyroscopic effect"
        ),
        *vector("rotor_torque_{}", rotor, "N m", r"\Gamma_{{\mathrm{{rot}},{}}}", "external torque of the rotors"),
        *vector("torque_{}", torque, "N m", r"\Gamma_{{{}}}", "total torque, moment of inertia times acceleration"),
    )
