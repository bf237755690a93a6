"""The figure of a single cell: its orbit, how its exponents settle, and the spectrum of its first state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from quavsweep.codes import Region
from quavsweep.plot.convergence import convergence_handles, draw_convergence
from quavsweep.plot.legend import legend_above
from quavsweep.plot.orbit import add_orbit, orbit_height
from quavsweep.plot.spectrum import draw_spectrum
from quavsweep.plot.style import PAGE, style
from quavsweep.plot.title import LINE, cell_title
from quavsweep.plot.trace import Trace

if TYPE_CHECKING:
    from quavsweep.point import Point

LOWER = 2.5  # inches of the lower row


def make_point_figure(point: Point) -> Figure:
    """Return the figure of a single cell."""
    trace = point_trace(point)
    title = cell_title(point.sweep, point.orbit[0], int(point.values["region"]), PAGE)
    upper = orbit_height(trace)
    with style():
        height = upper + LOWER + LINE * (title.count("\n") + 1)
        figure = Figure(figsize=(PAGE, height), layout="constrained")
        figure.suptitle(title, fontsize=8)
        rows = GridSpec(2, 1, figure, height_ratios=[upper, LOWER])
        add_orbit(figure, rows[0], trace)
        with_exponents = point.exponents.shape[1] > 0
        lower = rows[1].subgridspec(1, 2 if with_exponents else 1)
        if with_exponents:
            axes = figure.add_subplot(lower[0])
            draw_convergence(axes, point)
            legend_above(axes, convergence_handles(point), 2.9)
        spacing = point.time[1] - point.time[0] if len(point.time) > 1 else 1.0
        draw_spectrum(figure.add_subplot(lower[-1]), trace.model, trace.shown[trace.late :, 0], float(spacing))
    return figure


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
