"""A model of twelve states for measuring kernels of higher dimension: Lorenz 96."""

from __future__ import annotations

from typing import Any

from quavsweep.models import Model, Parameter, State


def rhs(x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, F) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of a ring of twelve sites, dimensionless."""
    x = (x0, x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11)
    return tuple((x[(i + 1) % 12] - x[i - 2]) * x[i - 1] - x[i] + F for i in range(12))


MODEL = Model(
    name="lorenz96",
    rhs=rhs,
    states=tuple(State(f"x{i}") for i in range(12)),
    parameters=(Parameter("F", 8.0, meaning="forcing; chaotic at 8"),),
    source="E. N. Lorenz, Predictability: a problem partly solved, ECMWF seminar (1996)",
)
