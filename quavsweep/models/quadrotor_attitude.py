"""The attitude of a quadrotor whose four rotors turn as they like: system (13) of the paper with the torques (12)."""

from __future__ import annotations

from typing import Any

from quavsweep.models import body
from quavsweep.models.craft import TABLE_2
from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter


def rhs(  # type: ignore[no-untyped-def]
    p,
    q,
    r,
    Omega1,
    Omega2,
    Omega3,
    Omega4,
    Ix,
    Iy,
    Iz,
    Ir,
    b,
    l,  # noqa: E741
    d,
    k4,
    k5,
    k6,
) -> tuple[Any, ...]:
    """Angular accelerations in the body frame [rad/s2]: I domega/dt is the sum of the four torques of (7)."""
    x, y, z = torque(p, q, r, Omega1, Omega2, Omega3, Omega4, Ix, Iy, Iz, Ir, b, l, d, k4, k5, k6)
    return x / Ix, y / Iy, z / Iz


def torque(  # type: ignore[no-untyped-def]
    p,
    q,
    r,
    Omega1,
    Omega2,
    Omega3,
    Omega4,
    Ix,
    Iy,
    Iz,
    Ir,
    b,
    l,  # noqa: E741
    d,
    k4,
    k5,
    k6,
) -> tuple[Any, ...]:
    """I domega/dt [N m]."""
    torques = (
        body.inertial_torque(p, q, r, Ix, Iy, Iz),
        gyro_torque(p, q, Omega1, Omega2, Omega3, Omega4, Ir),
        body.drag_torque(p, q, r, k4, k5, k6),
        body.rotor_torque(Omega1, Omega2, Omega3, Omega4, b, l, d),
    )
    return tuple(sum(parts) for parts in zip(*torques, strict=True))


def gyro_torque(p, q, Omega1, Omega2, Omega3, Omega4, Ir) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Gyroscopic torque (10) [N m]."""
    return body.gyro_torque(p, q, Omega2 + Omega4 - Omega1 - Omega3, Ir)


def casimir_power(  # type: ignore[no-untyped-def]
    p,
    q,
    r,
    Omega1,
    Omega2,
    Omega3,
    Omega4,
    Ix,
    Iy,
    Iz,
    Ir,
    b,
    l,  # noqa: E741
    d,
    k4,
    k5,
    k6,
) -> Any:
    """Rate of the Casimir energy [W]."""
    return body.work(p, q, r, torque(p, q, r, Omega1, Omega2, Omega3, Omega4, Ix, Iy, Iz, Ir, b, l, d, k4, k5, k6))


def supplied_power(  # type: ignore[no-untyped-def]
    p,
    q,
    r,
    Omega1,
    Omega2,
    Omega3,
    Omega4,
    b,
    l,  # noqa: E741
    d,
) -> Any:
    """Power of the rotors [W]."""
    return body.work(p, q, r, body.rotor_torque(Omega1, Omega2, Omega3, Omega4, b, l, d))


def _speed(number: int, default: float, place: str) -> Parameter:
    return Parameter(
        f"Omega{number}", default, "rad/s", rf"\Omega_{number}", f"speed of rotor {number}, {place}", low=0.0
    )


MODEL = Model(
    name="quadrotor_attitude",
    rhs=rhs,
    states=body.RATES,
    parameters=(
        _speed(1, 196.4, "front"),
        _speed(2, 201.4, "left"),
        _speed(3, 196.4, "rear"),
        _speed(4, 201.4, "right"),
        *(TABLE_2[name] for name in ("Ix", "Iy", "Iz", "Ir", "b", "l", "d", "k4", "k5", "k6")),
    ),
    relations=body.RELATIONS,
    bound=1e4,
    time_unit="s",
    source="system (13) with the torques (12); speeds of Section 4's yaw manoeuvre, defaults from Table 2",
    example=Example(
        initial={"p": 1e-3, "q": 1e-3, "r": 1e-3},
        axes={"Omega1": (190.0, 202.0, 41), "Omega2": (196.0, 207.0, 41)},
        dt=0.01,
        transient=1000.0,
        duration=3000.0,
    ),
    observables=body.driven(torque, gyro_torque, body.rotor_torque, casimir_power, supplied_power),
)
