"""States against time, under each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from quavsweep.plot.decimate import extremes
from quavsweep.plot.scale import set_values
from quavsweep.plot.style import symbol, with_unit
from quavsweep.plot.trace import EARLY, LATE, MARK, Trace


def draw_series(panels: Sequence[Axes], trace: Trace, room: int) -> None:
    """Draw each state against time in a panel with room for so many characters; mark the end of the transient."""
    for i, (axes, state) in enumerate(zip(panels, trace.model.states, strict=True)):
        draw_course(axes, trace, trace.shown[:, i], state.name, room)
        axes.label_outer()
    panels[-1].set_xlabel(with_unit("$t$", trace.model.time_unit))


def draw_course(axes: Axes, trace: Trace, values: np.ndarray, name: str, room: int) -> None:
    """Draw a state or observable, (n,) values along an orbit, against time, without a label of the time."""
    for part, colour in ((slice(0, trace.late + 1), EARLY), (slice(trace.late, None), LATE)):
        kept = extremes(values[part])
        axes.plot(trace.time[part][kept], values[part][kept], color=colour, lw=0.5)
    if trace.transient_seen:
        axes.axvline(trace.transient, color=MARK, lw=0.8, ls="--")
    set_values(axes.yaxis, values, symbol(trace.model, name), trace.model.quantity(name).unit, room)
    axes.margins(x=0.0)


def series_handles(trace: Trace) -> list[Artist]:
    """Return a legend's line for the end of the transient, if it is drawn."""
    if not trace.transient_seen:
        return []
    return [Line2D([], [], color=MARK, lw=0.8, ls="--", label="end of the transient")]
