"""Chua's circuit with its piecewise linear resistor: the double scroll."""

from __future__ import annotations

from typing import Any

from quavsweep.models.function import absolute
from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, y, z, alpha, beta, m0, m1) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives of two voltages and a current; the resistor's slope is m0 within |x| < 1 and m1 outside."""
    h = m1 * x + (m0 - m1) * (absolute(x + 1) - absolute(x - 1)) / 2
    return alpha * (y - h), x - y + z, -beta * y


MODEL = Model(
    name="chua",
    rhs=rhs,
    states=(
        State("x", "1", "x", "voltage at the resistor"),
        State("y", "1", "y", "voltage at the inductor"),
        State("z", "1", "z", "current of the inductor"),
    ),
    parameters=(
        Parameter("alpha", 9.0, "1", r"\alpha", "ratio of the capacitors", low=0.0),
        Parameter("beta", 100.0 / 7.0, "1", r"\beta", "inverse inductance", low=0.0),
        Parameter("m0", -1.0 / 7.0, "1", "m_0", "inner slope of the resistor's line"),
        Parameter("m1", 2.0 / 7.0, "1", "m_1", "outer slope of the resistor's line"),
    ),
    symmetries=((-1, -1, -1),),
    bound=1e4,
    source="L. O. Chua, M. Komuro, T. Matsumoto, IEEE Trans. Circuits Syst. 33, 1072 (1986), equation (1.1)",
    example=Example(
        initial={"x": 0.1, "y": 0.0, "z": 0.0},
        axes={"alpha": (6.0, 10.0, 81)},
        dt=0.01,
        transient=200.0,
        duration=800.0,
    ),
)
