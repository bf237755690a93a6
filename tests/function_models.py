"""Models with functions and kinks, written as a user writes them, and called with floats by the twins."""

from __future__ import annotations

from typing import Any

from quavsweep.models import Model, Parameter, State
from quavsweep.models.function import (
    absolute,
    cosh,
    exp,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sinh,
    sqrt,
    tan,
    tanh,
    where,
)


def pendulum(theta, omega, stiffness, damping, torque) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    return omega, -stiffness * sin(theta) - damping * omega + torque


def chua(x, y, z, alpha, beta, a, b) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    current = b * x + (a - b) / 2 * (absolute(x + 1) - absolute(x - 1))
    return alpha * (y - x - current), x - y + z, -beta * y


def rectifier(x, y, z, gain, leak) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    dx = gain * tanh(y) - leak * x + sinh(x / 4) - minimum(z, gain)
    dy = exp(-x * x) - y + maximum(x, 0) * log(2 + z * z)
    dz = tan(x / 3) - z / cosh(y) + 0.1 * sign(y) * sqrt(1 + z * z)
    return dx, dy, dz


def stages(x, y, low, high) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    inside = where((x > low) & (x <= high), x * y, exp(x) - 1)
    return y - where((y < low) | (y > high), low * y, y**3), -inside


def _model(function: Any, states: str, **parameters: float) -> Model:
    return Model(
        function.__name__,
        function,
        tuple(State(name) for name in states.split()),
        tuple(Parameter(name, value) for name, value in parameters.items()),
    )


PENDULUM = _model(pendulum, "theta omega", stiffness=4.0, damping=0.2, torque=0.5)
CHUA = _model(chua, "x y z", alpha=9.0, beta=100 / 7, a=-8 / 7, b=-5 / 7)
RECTIFIER = _model(rectifier, "x y z", gain=1.3, leak=0.7)
STAGES = _model(stages, "x y", low=-0.5, high=0.75)
MODELS = {model.name: model for model in (PENDULUM, CHUA, RECTIFIER, STAGES)}
