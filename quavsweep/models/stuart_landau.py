"""The Stuart-Landau oscillator: the normal form of a Hopf bifurcation, with a circle for a limit cycle."""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, y, mu, omega) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of the real and imaginary part of z' = (mu + i omega - |z|^2) z."""
    growth = mu - x**2 - y**2
    return growth * x - omega * y, growth * y + omega * x


MODEL = Model(
    name="stuart_landau",
    rhs=rhs,
    states=(State("x", "1", "x", "real part"), State("y", "1", "y", "imaginary part")),
    parameters=(
        Parameter("mu", 1.0, "1", r"\mu", "linear growth; the cycle has the radius of its root"),
        Parameter("omega", 1.0, "1", r"\omega", "angular frequency"),
    ),
    symmetries=((-1, -1),),
    bound=1e4,
    source="L. D. Landau (1944); J. T. Stuart, J. Fluid Mech. 9, 353 (1960), equation (1.1)",
    example=Example(
        initial={"x": 0.1, "y": 0.0},
        axes={"mu": (-1.0, 2.0, 31)},
        dt=0.02,
        transient=100.0,
        duration=400.0,
    ),
)
