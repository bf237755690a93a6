"""A permanent-magnet synchronous motor with a smooth air gap, in the rotor's frame and without dimensions.

Without voltage u_q and load T_L it is symmetric under (i_d, i_q, w) -> (i_d, -i_q, -w), and without any input it is
the Lorenz system with x = w, y = i_q, z = i_d, rho = gamma and beta = 1.
"""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(i_d, i_q, w, gamma, sigma, u_d, u_q, T_L) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of two currents and the speed, in units of the electrical time constant."""
    return -i_d + i_q * w + u_d, -i_q - i_d * w + gamma * w + u_q, sigma * (i_q - w) - T_L


MODEL = Model(
    name="pmsm",
    rhs=rhs,
    states=(
        State("i_d", "1", "i_d", "current along the rotor's field"),
        State("i_q", "1", "i_q", "current across the rotor's field"),
        State("w", "1", r"\omega", "speed"),
    ),
    parameters=(
        Parameter("gamma", 20.0, "1", r"\gamma", "flux of the magnets"),
        Parameter("sigma", 5.46, "1", r"\sigma", "friction against inertia", low=0.0),
        Parameter("u_d", 0.0, "1", "u_d", "voltage along the field"),
        Parameter("u_q", 0.0, "1", "u_q", "voltage across the field"),
        Parameter("T_L", 0.0, "1", "T_L", "torque of the load"),
    ),
    bound=1e4,
    source="Z. Li, J. B. Park, Y. H. Joo, B. Zhang, G. Chen, IEEE Trans. Circuits Syst. I 49, 383 (2002)",
    example=Example(
        initial={"i_d": 20.0, "i_q": 0.01, "w": -5.0},
        axes={"gamma": (0.5, 30.0, 60)},
        dt=0.005,
        transient=100.0,
        duration=400.0,
    ),
)
