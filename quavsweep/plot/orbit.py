"""The orbit of one cell: in space and, beside that, each state against time."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from quavsweep.plot.legend import legend_above
from quavsweep.plot.series import draw_series, series_handles
from quavsweep.plot.space import draw_space, space_dimensions
from quavsweep.plot.trace import Trace

PER_STATE = 0.75  # inches
LEAST = 2.8


def orbit_height(trace: Trace) -> float:
    """Return the height in inches that an orbit needs."""
    return max(LEAST if space_dimensions(trace.model) else 1.6, PER_STATE * len(trace.model.states) + 0.5)


def add_orbit(figure: Figure, place: SubplotSpec, trace: Trace) -> None:
    """Draw an orbit into a part of a figure."""
    halves = place.subgridspec(1, 2 if space_dimensions(trace.model) else 1, wspace=0.1)
    if space_dimensions(trace.model):
        draw_space(figure, halves[0], trace)
    rows = halves[-1].subgridspec(len(trace.model.states), 1, hspace=0.05)
    panels = list(rows.subplots(sharex=True, squeeze=False)[:, 0])
    draw_series(panels, trace)
    legend_above(panels[0], series_handles(trace), 3.0)
    figure.align_ylabels(panels)
