"""The Lorenz system."""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, y, z, sigma, rho, beta) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of the three convection amplitudes, in units of the model's time."""
    return sigma * (y - x), x * (rho - z) - y, x * y - beta * z


MODEL = Model(
    name="lorenz",
    rhs=rhs,
    states=(
        State("x", "1", "x", "convective overturning"),
        State("y", "1", "y", "horizontal temperature variation"),
        State("z", "1", "z", "vertical temperature variation"),
    ),
    parameters=(
        Parameter("sigma", 10.0, "1", r"\sigma", "Prandtl number", low=0.0),
        Parameter("rho", 28.0, "1", r"\rho", "reduced Rayleigh number"),
        Parameter("beta", 8.0 / 3.0, "1", r"\beta", "geometric factor", low=0.0),
    ),
    symmetries=((-1, -1, 1),),
    bound=1e5,
    source="E. N. Lorenz, J. Atmos. Sci. 20, 130 (1963), equations (25) to (27)",
    example=Example(
        initial={"x": 1.0, "y": 1.0, "z": 20.0},
        axes={"rho": (0.5, 200.0, 400), "beta": (0.5, 4.0, 36)},
        dt=0.005,
        transient=100.0,
        duration=400.0,
        block=20,
    ),
)
