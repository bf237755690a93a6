"""A torus: the Stuart-Landau oscillator beside an angle that turns at a rate of its own."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

from quavsweep.models import stuart_landau
from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, y, psi, mu, omega, nu) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of z' = (mu + i omega - |z|^2) z and psi' = nu; quasi-periodic unless nu / omega is rational."""
    return *stuart_landau.rhs(x, y, mu, omega), nu


MODEL = Model(
    name="torus",
    rhs=rhs,
    states=(*stuart_landau.MODEL.states, State("psi", "rad", r"\psi", "angle", circle=2 * pi)),
    parameters=(*stuart_landau.MODEL.parameters, Parameter("nu", sqrt(2.0), "1", r"\nu", "rate of the angle")),
    symmetries=((-1, -1, 1),),
    bound=1e4,
    source="closed form: two oscillators that do not know of each other",
    example=Example(
        initial={"x": 0.1, "y": 0.0, "psi": 0.0},
        axes={"nu": (0.5, 2.0, 31)},
        dt=0.02,
        transient=100.0,
        duration=400.0,
    ),
)
