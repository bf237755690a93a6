"""Orbit diagrams of the paper: the roll rate and the Casimir power at its maxima."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quavsweep.codes import Region
from quavsweep.kernels.observe import observe
from quavsweep.plot.bifurcation import Dots, make_bifurcation_figure
from quavsweep.plot.strip import Strips
from quavsweep.plot.style import symbol
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POWER = "casimir_power"


def power_at(result: Result, u: np.ndarray, name: str = POWER) -> np.ndarray:
    """Return a power [W] of states of the cells of a sweep with one axis.

    Parameters
    ----------
    u : (n, ..., D) float64
    """
    sweep = result.sweep
    (axis,) = sweep.grid.axes
    ones = (1,) * (u.ndim - 2)
    varied = {name: np.asarray(values).reshape(-1, *ones) for name, values in axis.quantities.items()}
    return np.asarray(observe(sweep.model, (name,), u, {**sweep.parameters, **varied})[..., 0])


def sink_power(seen: Result, where: str) -> float:
    """Return the largest Casimir power in cells that end in a sink, as a share of the power that is supplied.

    Parameters
    ----------
    where : str
        The states that are looked at, `equilibrium` or `final_state`.
    """
    power, supplied = (np.abs(power_at(seen, seen[where], name)) for name in (POWER, "supplied_power"))
    sink = (seen["region"] == Region.SINK) & (supplied > 0)
    return float(np.max(power[sink] / supplied[sink], initial=0.0))


def draw_diagram(result: Result, seen: Result, strips: Strips) -> Figure:
    """Draw roll rate and Casimir power at the maxima of the roll rate; of cells that are sinks by then, at the sink."""
    sink = (seen["region"] == Region.SINK)[:, None]
    states = np.where(sink[..., None], np.nan, result["samples"])
    states[:, 0] = np.where(sink, seen["equilibrium"], states[:, 0])
    power = power_at(result, states)
    p = symbol(result.sweep.model, "p")
    panels = [Dots(states[..., 0], f"maxima of {p}", "rad/s"), Dots(power, "Casimir power", "W")]
    return make_bifurcation_figure(result, panels, strips)
