"""The Rössler system: a spiral that is folded back."""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, y, z, a, b, c) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of the three concentrations, in units of the model's time."""
    return -y - z, x + a * y, b + z * (x - c)


MODEL = Model(
    name="rossler",
    rhs=rhs,
    states=(State("x"), State("y"), State("z")),
    parameters=(
        Parameter("a", 0.2, "1", "a", "growth of the spiral"),
        Parameter("b", 0.2, "1", "b", "injection"),
        Parameter("c", 5.7, "1", "c", "where injection sets in"),
    ),
    bound=1e4,
    source="O. E. Rössler, Phys. Lett. A 57, 397 (1976), equation (2)",
    example=Example(
        initial={"x": 1.0, "y": 1.0, "z": 1.0},
        axes={"c": (2.0, 9.0, 71)},
        dt=0.02,
        transient=400.0,
        duration=1600.0,
        block=20,
    ),
)
