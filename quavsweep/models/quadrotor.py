"""A quadrotor in a yaw manoeuvre as a whole: angular velocity (15), Euler angles (16) and position (6) of the paper."""

from __future__ import annotations

from math import pi
from typing import Any

from quavsweep.models import body, quadrotor_yaw
from quavsweep.models.craft import TABLE_2
from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Observable, State, vector


def rhs(  # type: ignore[no-untyped-def]
    p,
    q,
    r,
    phi,
    theta,
    psi,
    x,
    y,
    z,
    vx,
    vy,
    vz,
    Omega1,
    c,
    Ix,
    Iy,
    Iz,
    Ir,
    d,
    k4,
    k5,
    k6,
    b,
    m,
    g,
    k1,
    k2,
    k3,
) -> tuple[Any, ...]:
    """Derivatives of angular velocity, Euler angles, position and velocity in SI units."""
    return (
        *quadrotor_yaw.rhs(p, q, r, Omega1, c, Ix, Iy, Iz, Ir, d, k4, k5, k6),
        *body.euler_rates(p, q, r, phi, theta),
        vx,
        vy,
        vz,
        *acceleration(phi, theta, psi, vx, vy, vz, Omega1, c, b, m, g, k1, k2, k3),
    )


def acceleration(phi, theta, psi, vx, vy, vz, Omega1, c, b, m, g, k1, k2, k3) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Acceleration by (6) [m/s2]; its vertical part is (23)."""
    lift, (x, y, z) = thrust(Omega1, c, b), body.upward(phi, theta, psi)
    drag = drag_force(vx, vy, vz, k1, k2, k3)
    return (lift * x - drag[0]) / m, (lift * y - drag[1]) / m, (lift * z - drag[2] - weight(m, g)) / m


def thrust(Omega1, c, b) -> Any:  # type: ignore[no-untyped-def]
    """F_T behind (3) [N]: rotors 1 and 3 turn at Omega1, 2 and 4 at Omega1 + c."""
    return 2 * b * (Omega1**2 + (Omega1 + c) ** 2)


def drag_force(vx, vy, vz, k1, k2, k3) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """F_d of (4) [N], which is subtracted."""
    return k1 * vx, k2 * vy, k3 * vz


def weight(m, g) -> Any:  # type: ignore[no-untyped-def]
    """F_g of (5), downward [N]."""
    return m * g


MODEL = Model(
    name="quadrotor",
    rhs=rhs,
    states=(
        *body.RATES,
        State("phi", "rad", r"\varphi", "roll angle, whole turns counted"),
        State("theta", "rad", r"\theta", "pitch angle", low=-pi / 2, high=pi / 2),
        State("psi", "rad", r"\psi", "yaw angle, whole turns counted"),
        State("x", "m", "x", "position, earth's frame"),
        State("y", "m", "y", "position, earth's frame"),
        State("z", "m", "z", "height"),
        State("vx", "m/s", "v_x", "velocity along x"),
        State("vy", "m/s", "v_y", "velocity along y"),
        State("vz", "m/s", "v_z", "velocity upward"),
    ),
    parameters=(
        *quadrotor_yaw.MODEL.parameters,
        *(TABLE_2[name] for name in ("b", "m", "g", "k1", "k2", "k3")),
    ),
    relations=body.RELATIONS,
    symmetries=((-1, -1, 1, -1, -1, 1, -1, -1, 1, -1, -1, 1),),
    bound=1e9,
    time_unit="s",
    source="systems (15), (16) and (6); defaults from Table 2 and Section 4",
    example=Example(
        initial={
            **dict.fromkeys(("p", "q", "r"), 1e-3),
            **dict.fromkeys(("phi", "theta", "psi", "x", "y"), 0.0),
            "z": 200.0,
            **dict.fromkeys(("vx", "vy", "vz"), 0.0),
        },
        axes={"Omega1": (150.0, 250.0, 41), "c": (3.0, 7.0, 41)},
        dt=0.01,
        transient=0.0,
        duration=60.0,
        exponents=0,
    ),
    observables=(
        *quadrotor_yaw.MODEL.observables,
        Observable("thrust", thrust, "N", "F_T", "thrust of the rotors"),
        *vector("drag_force_{}", drag_force, "N", "F_{{d,{}}}", "drag force"),
        Observable("weight", weight, "N", "F_g", "weight"),
        *vector("a{}", acceleration, "m/s2", "a_{}", "acceleration"),
    ),
)
