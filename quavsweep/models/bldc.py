"""A brushless direct-current motor in the rotor's frame, without dimensions.

With equal inductances (eta = 0) and no input it is the Lorenz system with x = w, y = i_q, z = i_d and beta = delta.
"""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(i_q, i_d, w, sigma, rho, eta, delta, v_q, v_d, T_L) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of two currents and the speed, in units of the electrical time constant."""
    return (
        v_q - i_q - i_d * w + rho * w,
        v_d - delta * i_d + i_q * w,
        sigma * (i_q - w) + eta * i_q * i_d - T_L,
    )


MODEL = Model(
    name="bldc",
    rhs=rhs,
    states=(
        State("i_q", "1", "i_q", "current across the rotor's field"),
        State("i_d", "1", "i_d", "current along the rotor's field"),
        State("w", "1", r"\omega", "speed"),
    ),
    parameters=(
        Parameter("sigma", 4.55, "1", r"\sigma", "friction against inertia", low=0.0),
        Parameter("rho", 60.0, "1", r"\rho", "flux of the magnets"),
        Parameter("eta", 0.26, "1", r"\eta", "torque of unequal inductances"),
        Parameter("delta", 0.875, "1", r"\delta", "ratio of the inductances", low=0.0),
        Parameter("v_q", 0.168, "1", "v_q", "voltage across the field"),
        Parameter("v_d", 20.66, "1", "v_d", "voltage along the field"),
        Parameter("T_L", 0.53, "1", "T_L", "torque of the load"),
    ),
    bound=1e5,
    source=(
        "N. Hemati, IEEE Trans. Circuits Syst. I 41, 40 (1994); "
        "parameters of Z.-M. Ge, C.-M. Chang, Chaos Solitons Fractals 20, 883 (2004)"
    ),
    example=Example(
        initial={"i_q": 0.01, "i_d": 0.01, "w": 0.01},
        axes={"rho": (0.5, 80.0, 160)},
        dt=0.002,
        transient=40.0,
        duration=160.0,
    ),
)
