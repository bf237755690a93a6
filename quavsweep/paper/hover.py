"""Hovering by Table 2: the curve (22) with the craft's constants, and its place in the figures."""

from __future__ import annotations

import numpy as np

from quavsweep.analysis.quadrotor.hovering import hovering_speed
from quavsweep.models.craft import TABLE_2
from quavsweep.plot.overlay import Curve
from quavsweep.result import Result

MASS, GRAVITY, LIFT = (TABLE_2[name].default for name in ("m", "g", "b"))


def hovering_curve(result: Result) -> Curve:
    """Return the curve over a map of Omega1 and c."""
    up = np.asarray(result.sweep.grid.axes[1].values)
    c = np.linspace(up.min(), up.max(), 101)
    return Curve("hovering, (22)", (np.column_stack([hovering_speed(c, MASS, GRAVITY, LIFT), c]),))
