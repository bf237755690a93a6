"""The attitude of a quadrotor in a yaw manoeuvre: system (15) of the paper."""

from __future__ import annotations

from typing import Any

from quavsweep.models import body
from quavsweep.models.craft import TABLE_2
from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter


def rhs(p, q, r, Omega1, c, Ix, Iy, Iz, Ir, d, k4, k5, k6) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Angular accelerations in the body frame [rad/s2]; rotors 1 and 3 turn at Omega1, 2 and 4 at Omega1 + c."""
    dp = ((Iy - Iz) * q * r - 2 * c * Ir * q - k4 * p) / Ix
    dq = ((Iz - Ix) * p * r + 2 * c * Ir * p - k5 * q) / Iy
    dr = ((Ix - Iy) * p * q - k6 * r + 2 * d * (c**2 + 2 * c * Omega1)) / Iz
    return dp, dq, dr


def torque(p, q, r, Omega1, c, Ix, Iy, Iz, Ir, d, k4, k5, k6) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """I domega/dt [N m]."""
    dp, dq, dr = rhs(p, q, r, Omega1, c, Ix, Iy, Iz, Ir, d, k4, k5, k6)
    return Ix * dp, Iy * dq, Iz * dr


def casimir_power(p, q, r, Omega1, c, Ix, Iy, Iz, Ir, d, k4, k5, k6) -> Any:  # type: ignore[no-untyped-def]
    """Rate of the Casimir energy, second line of (20) [W]."""
    return body.work(p, q, r, torque(p, q, r, Omega1, c, Ix, Iy, Iz, Ir, d, k4, k5, k6))


def gyro_torque(p, q, c, Ir) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Gyroscopic torque [N m]: (10) with (14), Omega = 2 c."""
    return body.gyro_torque(p, q, 2 * c, Ir)


def rotor_torque(Omega1, c, d) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Torque of the rotors [N m]: (12) with (14)."""
    return 0, 0, 2 * d * (c**2 + 2 * c * Omega1)


def supplied_power(r, Omega1, c, d) -> Any:  # type: ignore[no-untyped-def]
    """Power of the rotors, before (20)'s last bracket [W]."""
    return body.work(0, 0, r, rotor_torque(Omega1, c, d))


MODEL = Model(
    name="quadrotor_yaw",
    rhs=rhs,
    states=body.RATES,
    parameters=(
        Parameter("Omega1", 196.4, "rad/s", r"\Omega_1", "speed of the front and rear rotors", low=0.0),
        Parameter("c", 5.0, "rad/s", "c", "speed of the left and right rotors less that of the front and rear ones"),
        *(TABLE_2[name] for name in ("Ix", "Iy", "Iz", "Ir", "d", "k4", "k5", "k6")),
    ),
    relations=body.RELATIONS,
    symmetries=((-1, -1, 1),),
    bound=1e4,
    time_unit="s",
    source="system (15): equation (13) under conditions (14); defaults from Table 2 and Section 4",
    example=Example(
        initial={"p": 1e-3, "q": 1e-3, "r": 1e-3},
        axes={"Omega1": (50.0, 500.0, 91), "c": (3.0, 7.0, 41)},
        dt=0.02,
        transient=1000.0,
        duration=3000.0,
    ),
    observables=body.driven(torque, gyro_torque, rotor_torque, casimir_power, supplied_power),
)
