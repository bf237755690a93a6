"""The attitude of a quadrotor in a yaw manoeuvre: system (15) of the paper."""

from __future__ import annotations

from typing import Any

from quavsweep.models.craft import TABLE_2
from quavsweep.models.model import Example, Model, Parameter, Relation, State


def rhs(p, q, r, Omega1, c, Ix, Iy, Iz, Ir, d, k4, k5, k6) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Angular accelerations in the body frame [rad/s2]; rotors 1 and 3 turn at Omega1, 2 and 4 at Omega1 + c."""
    dp = ((Iy - Iz) * q * r - 2 * c * Ir * q - k4 * p) / Ix
    dq = ((Iz - Ix) * p * r + 2 * c * Ir * p - k5 * q) / Iy
    dr = ((Ix - Iy) * p * q - k6 * r + 2 * d * (c**2 + 2 * c * Omega1)) / Iz
    return dp, dq, dr


MODEL = Model(
    name="quadrotor_yaw",
    rhs=rhs,
    states=(
        State("p", "rad/s", "p", "roll rate, body frame"),
        State("q", "rad/s", "q", "pitch rate, body frame"),
        State("r", "rad/s", "r", "yaw rate, body frame"),
    ),
    parameters=(
        Parameter("Omega1", 196.4, "rad/s", r"\Omega_1", "speed of the front and rear rotors", low=0.0),
        Parameter("c", 5.0, "rad/s", "c", "speed of the left and right rotors less that of the front and rear ones"),
        *(TABLE_2[name] for name in ("Ix", "Iy", "Iz", "Ir", "d", "k4", "k5", "k6")),
    ),
    relations=(
        Relation("Ix <= Iy + Iz", lambda Ix, Iy, Iz: Ix <= Iy + Iz, "no rigid body has such moments of inertia"),
        Relation("Iy <= Ix + Iz", lambda Ix, Iy, Iz: Iy <= Ix + Iz, "no rigid body has such moments of inertia"),
        Relation("Iz <= Ix + Iy", lambda Ix, Iy, Iz: Iz <= Ix + Iy, "no rigid body has such moments of inertia"),
    ),
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
)
