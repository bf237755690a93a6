"""Orbits in space, each with the power of its energy beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.models import Observable
from quavsweep.plot.decimate import extremes
from quavsweep.plot.legend import legend_height, legend_outside
from quavsweep.plot.scale import set_values
from quavsweep.plot.series import series_handles
from quavsweep.plot.space import draw_space, space_handles
from quavsweep.plot.style import PAGE, with_unit
from quavsweep.plot.trace import EARLY, LATE, MARK, Trace

ROW = 1.95  # inches
SHARES = (0.4, 0.6)  # of the width


@dataclass(frozen=True)
class Powered:
    """An orbit and its power.

    Parameters
    ----------
    title : str
        What tells it from the others, in a few symbols.
    trace : Trace
    power : (n,) float64
        At the times of the trace [W].
    """

    title: str
    trace: Trace
    power: np.ndarray


def make_power_figure(orbits: Sequence[Powered], power: Observable) -> Figure:
    """Return a row for each orbit: in space on the left, its power against time on the right."""
    handles = space_handles(max((orbit.trace for orbit in orbits), key=lambda trace: trace.equilibrium is not None))
    handles += series_handles(orbits[0].trace)
    count, above = len(orbits), legend_height(handles, PAGE) + 0.1
    height = ROW * count + above
    figure = Figure(figsize=(PAGE, height), layout="constrained")
    rows = figure.add_gridspec(count, 2, width_ratios=SHARES)
    letters = iter("abcdefghijklmnopqrstuvwxyz")
    panels: list[Axes] = []
    for i, orbit in enumerate(orbits):
        space = draw_space(figure, rows[i, 0], orbit.trace, legend=False)
        bottom = ROW * (count - 1 - i)
        space.set_position((0.01, (bottom + 0.33) / height, SHARES[0] - 0.07, (ROW - 0.55) / height))
        figure.text(0.01, (bottom + ROW - 0.12) / height, f"({next(letters)}) {orbit.title}", va="top")
        axes = figure.add_subplot(rows[i, 1], sharex=panels[0] if panels else None)
        panels.append(axes)
        _draw_power(axes, orbit, power)
        axes.set_title(f"({next(letters)})", loc="left")
        axes.tick_params(labelbottom=i == count - 1)
    panels[-1].set_xlabel(with_unit("$t$", orbits[0].trace.model.time_unit))
    legend_outside(figure, handles, "upper")
    figure.align_ylabels(panels)
    return figure


def _draw_power(axes: Axes, orbit: Powered, power: Observable) -> None:
    """Draw a power against time, its early part pale."""
    trace = orbit.trace
    for part, colour in ((slice(0, trace.late + 1), EARLY), (slice(trace.late, None), LATE)):
        kept = extremes(orbit.power[part])
        axes.plot(trace.time[part][kept], orbit.power[part][kept], color=colour, lw=0.5)
    if trace.transient_seen:
        axes.axvline(trace.transient, color=MARK, lw=0.8, ls="--")
    axes.axhline(0.0, color="0.3", lw=0.5, ls=":")
    set_values(axes.yaxis, orbit.power, f"${power.symbol}$", power.unit)
    axes.margins(x=0.0)
