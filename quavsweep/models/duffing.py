"""The forced Duffing oscillator: a double well, damped and shaken."""

from __future__ import annotations

from math import pi
from typing import Any

from quavsweep.models.function import cos
from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(t, x, v, delta, alpha, beta, gamma, omega) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Velocity and acceleration of x'' + delta x' + alpha x + beta x^3 = gamma cos(omega t)."""
    return v, gamma * cos(omega * t) - delta * v - alpha * x - beta * x**3


MODEL = Model(
    name="duffing",
    rhs=rhs,
    states=(State("x", "1", "x", "position"), State("v", "1", "v", "velocity")),
    parameters=(
        Parameter("delta", 0.3, "1", r"\delta", "damping", low=0.0),
        Parameter("alpha", -1.0, "1", r"\alpha", "linear stiffness, negative for a double well"),
        Parameter("beta", 1.0, "1", r"\beta", "cubic stiffness"),
        Parameter("gamma", 0.5, "1", r"\gamma", "amplitude of the forcing"),
        Parameter("omega", 1.2, "1", r"\omega", "angular frequency of the forcing", low=0.0, open_low=True),
    ),
    forcing_period=lambda omega: 2 * pi / omega,
    bound=1e4,
    source="G. Duffing (1918); J. Guckenheimer, P. Holmes, Nonlinear Oscillations (1983), equation (2.2.2)",
    example=Example(
        initial={"x": 1.0, "v": 0.0},
        axes={"gamma": (0.2, 0.65, 46)},
        dt=0.02,
        transient=500.0,
        duration=1500.0,
        block=10,
    ),
)
