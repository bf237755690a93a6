"""The hovering curve: itself, the regions along it, and where it lies over a map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.grid import Axis
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.colour import choose_scale
from quavsweep.plot.legend import legend_height, legend_outside
from quavsweep.plot.map import draw_map
from quavsweep.plot.overlay import Curve, draw_curves
from quavsweep.plot.scale import drawn_range, set_scale
from quavsweep.plot.strip import Strips, draw_strips, strip_handles
from quavsweep.plot.style import PAGE
from quavsweep.plot.twice import time_text

if TYPE_CHECKING:
    from quavsweep.result import Result

ROW = 2.6  # inches
LABEL = "hovering, (22)"


def make_hovering_figure(curve: Result, strips: Strips, plane: Result) -> Figure:
    """Return three panels: Omega1 over c, the regions along c, and the curve over the map of a plane.

    Parameters
    ----------
    curve : Result
        Over a zipped axis of c and Omega1.
    strips : dict
        What is told of the regions along it.
    plane : Result
        Over Omega1 and c.
    """
    along = curve.sweep.grid.axes[0].quantities
    difference, speed = (Axis(name, along[name]) for name in ("c", "Omega1"))
    line = Curve(LABEL, (np.column_stack([speed.values, difference.values]),))
    handles = [*strip_handles({**strips, "map": plane["region"].ravel()}), line.handle]
    figure = Figure(figsize=(PAGE, ROW + legend_height(handles, PAGE)), layout="constrained")
    first, second, third = figure.subplots(1, 3)
    first.plot(difference.values, speed.values, color="black")
    _finish(first, curve, difference, "(a) hovering")
    set_scale(first.yaxis, curve.sweep.model, speed)
    draw_strips(second, np.asarray(difference.values), strips)
    second.tick_params(axis="y", rotation=90)
    for text in second.get_yticklabels():
        text.set_verticalalignment("center")
    _finish(second, curve, difference, "(b) along the curve")
    quantity = Catalogue(plane).find("region")
    draw_map(third, plane, quantity, choose_scale([quantity], None))
    draw_curves(third, [line])
    third.set_title(f"(c) region at {time_text(plane)}")
    legend_outside(figure, handles, "upper")
    return figure


def _finish(axes: Axes, result: Result, axis: Axis, title: str) -> None:
    """Give a panel over an axis its limits, label and title."""
    axes.set_xlim(*drawn_range(axis))
    set_scale(axes.xaxis, result.sweep.model, axis)
    axes.set_title(title)
