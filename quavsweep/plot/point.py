"""The figure of a single cell: its orbit, how its exponents settle, and the spectrum of its first state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec, SubplotSpec

from quavsweep.codes import Region
from quavsweep.plot.convergence import convergence_handles, draw_convergence
from quavsweep.plot.legend import legend_above, legend_height
from quavsweep.plot.orbit import add_orbit, orbit_height
from quavsweep.plot.spectrum import draw_spectrum
from quavsweep.plot.style import PAGE, style
from quavsweep.plot.title import LINE, cell_title
from quavsweep.plot.trace import Trace

if TYPE_CHECKING:
    from quavsweep.point import Point

LOWER = 2.2  # inches of the lower row, without its legend
WIDTH = 2.9  # inches of that


def make_point_figure(point: Point) -> Figure:
    """Return the figure of a single cell."""
    trace = point_trace(point)
    title = cell_title(point.sweep, point.orbit[0], int(point.values["region"]), PAGE, point.chosen)
    with style():
        heights = orbit_height(trace), LOWER + legend_height(convergence_handles(point), WIDTH)
        figure = Figure(figsize=(PAGE, sum(heights) + LINE * (title.count("\n") + 1)), layout="constrained")
        figure.suptitle(title, fontsize=8)
        rows = GridSpec(2, 1, figure, height_ratios=heights)
        add_orbit(figure, rows[0], trace)
        _add_lower(figure, rows[1], point, trace)
    return figure


def _add_lower(figure: Figure, place: SubplotSpec, point: Point, trace: Trace) -> None:
    """Draw how the exponents settle, if there are any, and the spectrum."""
    with_exponents = point.exponents.shape[1] > 0
    halves = place.subgridspec(1, 2 if with_exponents else 1)
    if with_exponents:
        axes = figure.add_subplot(halves[0])
        draw_convergence(axes, point)
        legend_above(axes, convergence_handles(point), WIDTH)
    spacing = point.time[1] - point.time[0] if len(point.time) > 1 else 1.0
    draw_spectrum(figure.add_subplot(halves[-1]), trace.model, trace.shown[trace.late :, 0], float(spacing))


def point_trace(point: Point) -> Trace:
    """Return the orbit of a cell with what is known of its parts."""
    sink = int(point.values["region"]) == Region.SINK
    return Trace(
        point.sweep.model,
        point.time,
        point.orbit,
        point.sweep.clock.transient,
        np.asarray(point.values["equilibrium"]) if sink else None,
    )
