"""Chen's system: an anti-controlled relative of Lorenz'."""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, y, z, a, b, c) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives in units of the model's time."""
    return a * (y - x), (c - a) * x - x * z + c * y, x * y - b * z


MODEL = Model(
    name="chen",
    rhs=rhs,
    states=(State("x"), State("y"), State("z")),
    parameters=(
        Parameter("a", 35.0, "1", "a", "rate at which x follows y", low=0.0),
        Parameter("b", 3.0, "1", "b", "decay of z", low=0.0),
        Parameter("c", 28.0, "1", "c", "growth of y"),
    ),
    symmetries=((-1, -1, 1),),
    bound=1e4,
    source="G. Chen, T. Ueta, Int. J. Bifurcation Chaos 9, 1465 (1999), equation (2)",
    example=Example(
        initial={"x": 1.0, "y": 1.0, "z": 20.0},
        axes={"c": (18.0, 30.0, 61)},
        dt=0.002,
        transient=40.0,
        duration=160.0,
    ),
)
