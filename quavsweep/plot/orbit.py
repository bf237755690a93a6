"""The orbit of one cell: in space and, beside that, each state against time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from quavsweep.plot.legend import legend_above
from quavsweep.plot.series import draw_series, series_handles
from quavsweep.plot.space import draw_space, space_dimensions
from quavsweep.plot.style import say
from quavsweep.plot.trace import Trace

PER_STATE, OF_MANY = 0.75, 0.6  # inches of a panel of time series, and of one of many
MANY = 4
LEAST = 2.9
SPACE = 3  # dimensions
CHARACTERS = 14  # per inch beside a panel


def orbit_height(trace: Trace) -> float:
    """Return the height in inches that an orbit needs."""
    least = LEAST if space_dimensions(trace.model) else 1.6
    return max(least, _series_height(trace) * len(trace.model.states) + 0.5)


def _series_height(trace: Trace) -> float:
    return PER_STATE if len(trace.model.states) <= MANY else OF_MANY


def add_orbit(figure: Figure, place: SubplotSpec, trace: Trace) -> None:
    """Draw an orbit into a part of a figure."""
    if not np.isfinite(trace.shown).any():
        say(figure.add_subplot(place, xticks=[], yticks=[]), "no value")
        return
    halves = place.subgridspec(1, 2 if space_dimensions(trace.model) else 1, wspace=0.1)
    if space_dimensions(trace.model):
        # Room beside and below for the labels of a space, which layouts know nothing of.
        room = halves[0].subgridspec(2, 2, width_ratios=(0.88, 0.12), height_ratios=(0.93, 0.07))
        draw_space(figure, room[0, 0] if space_dimensions(trace.model) == SPACE else halves[0], trace)
    rows = halves[-1].subgridspec(len(trace.model.states), 1, hspace=0.05)
    panels = list(rows.subplots(sharex=True, squeeze=False)[:, 0])
    draw_series(panels, trace, int(CHARACTERS * _series_height(trace)))
    legend_above(panels[0], series_handles(trace), 3.0)
    figure.align_ylabels(panels)
