"""Orbits in space, each with the power of its energy beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.models import Model, Observable
from quavsweep.plot.decimate import extremes
from quavsweep.plot.scale import set_values
from quavsweep.plot.space import draw_space
from quavsweep.plot.style import PAGE, with_unit
from quavsweep.plot.trace import EARLY, LATE, MARK, Trace

ROW = 2.15  # inches


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
    figure = Figure(figsize=(PAGE, ROW * len(orbits)), layout="constrained")
    rows = figure.add_gridspec(len(orbits), 2, width_ratios=(0.42, 0.58))
    letters = iter("abcdefghijklmnopqrstuvwxyz")
    panels: list[Axes] = []
    for i, orbit in enumerate(orbits):
        room = rows[i, 0].subgridspec(2, 2, width_ratios=(0.86, 0.14), height_ratios=(0.9, 0.1))
        space = draw_space(figure, room[0, 0], orbit.trace)
        space.text2D(-0.12, 1.0, f"({next(letters)}) {orbit.title}", transform=space.transAxes)  # type: ignore[attr-defined]
        axes = figure.add_subplot(rows[i, 1], sharex=panels[0] if panels else None)
        panels.append(axes)
        trace = orbit.trace
        for part, colour in ((slice(0, trace.late + 1), EARLY), (slice(trace.late, None), LATE)):
            kept = extremes(orbit.power[part])
            axes.plot(trace.time[part][kept], orbit.power[part][kept], color=colour, lw=0.5)
        if trace.transient_seen:
            axes.axvline(trace.transient, color=MARK, lw=0.8, ls="--")
        axes.axhline(0.0, color="0.3", lw=0.5, ls=":")
        set_values(axes.yaxis, orbit.power, f"${power.symbol}$", power.unit)
        axes.set_title(f"({next(letters)})", loc="left")
        axes.margins(x=0.0)
        axes.label_outer()
    panels[-1].set_xlabel(with_unit("$t$", _time_unit(orbits)))
    figure.align_ylabels(panels)
    return figure


def _time_unit(orbits: Sequence[Powered]) -> str:
    model: Model = orbits[0].trace.model
    return model.time_unit
