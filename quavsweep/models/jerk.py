"""The simplest quadratic jerk system: one equation of third order with a single parameter.

Most starts escape, and below A = 2.017 nearly all; (0, 0.5, 0) stays up to A = 2.15.
"""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, v, w, A) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Velocity, acceleration and jerk of x''' = -A x'' + x'^2 - x."""
    return v, w, -A * w + v**2 - x


MODEL = Model(
    name="jerk",
    rhs=rhs,
    states=(
        State("x", "1", "x", "position"),
        State("v", "1", "v", "velocity"),
        State("w", "1", "w", "acceleration"),
    ),
    parameters=(Parameter("A", 2.017, "1", "A", "damping of the acceleration"),),
    bound=1e3,
    source="J. C. Sprott, Phys. Lett. A 228, 271 (1997), equation (3)",
    example=Example(
        initial={"x": 0.0, "v": 0.5, "w": 0.0},
        axes={"A": (2.02, 2.15, 66)},
        dt=0.02,
        transient=1000.0,
        duration=4000.0,
    ),
)
