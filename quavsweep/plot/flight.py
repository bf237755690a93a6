"""Flights of several cells together: the same quantities over time, up to where each reaches the ground."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D

from quavsweep.codes import Region
from quavsweep.plot.legend import LOOK, legend_outside
from quavsweep.plot.observed import observed
from quavsweep.plot.scale import set_values
from quavsweep.plot.space import draw_space, space_handles
from quavsweep.plot.style import LINES, PAGE, style, symbol, with_unit
from quavsweep.plot.trace import Trace

if TYPE_CHECKING:
    from quavsweep.result import Result

COLOURS = LINES[1:4]  # blue, orange and green, as the paper's
DASHES = ("-", (0, (5, 1)), (0, (1.5, 0.8)))
COLUMNS = 2
HEIGHT = 1.5  # inches of a panel
BOX = 2.7  # inches of a space
ROOM = 22  # characters beside a panel


def make_flight_figure(result: Result, names: Sequence[str], texts: Sequence[str], ends: np.ndarray) -> Figure:
    """Return panels of states and observables of the cells along the only axis against time.

    Parameters
    ----------
    result : Result
        With the measure `orbit`.
    names : sequence of str
        States and observables, a panel each.
    texts : sequence of str
        What the cells are called.
    ends : (cells,) float64
        Times of impact, where each course ends; NaN without one.
    """
    model, time, rows = result.sweep.model, result["time"], -(-len(names) // COLUMNS)
    with style():
        figure = Figure(figsize=(PAGE, HEIGHT * rows + 0.5), layout="constrained")
        panels = figure.subplots(rows, COLUMNS, sharex=True, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=True):
            every = course(result, name)
            for values, end, colour, dashes in zip(every, ends, COLOURS, DASHES, strict=True):
                flying = ~(time > end)
                axes.plot(time[flying], values[flying], color=colour, ls=dashes, lw=0.9)
                if np.isfinite(end):
                    last = np.interp(end, time, values)
                    axes.plot(end, last, ls="", marker="X", ms=5, color=colour, mec="black", mew=0.5, zorder=3)
            seen = np.where(time > ends[:, None], np.nan, every)
            set_values(axes.yaxis, seen, symbol(model, name), model.quantity(name).unit, ROOM)
            axes.margins(x=0.0)
            axes.grid(color="0.9", lw=0.4)
        for axes in panels[-COLUMNS:]:
            axes.set_xlabel(with_unit("$t$", model.time_unit))
        figure.align_ylabels()
        legend_outside(figure, _handles(texts, bool(np.isfinite(ends).any())), "upper")
    return figure


def course(result: Result, name: str) -> np.ndarray:
    """Return a state or observable along the stored orbits, (cells, times)."""
    names = result.sweep.model.state_names
    return np.asarray(result["orbit"][..., names.index(name)] if name in names else observed(result, "orbit", name))


def _handles(texts: Sequence[str], falls: bool) -> list[Artist]:
    lines: list[Artist] = [
        Line2D([], [], color=colour, ls=dashes, lw=1.2, label=text)
        for text, colour, dashes in zip(texts, COLOURS, DASHES, strict=True)
    ]
    mark = Line2D([], [], ls="", marker="X", ms=5, color="white", mec="black", mew=0.5, label="impact")
    return [*lines, mark] if falls else lines


def make_spaces_figure(result: Result, texts: Sequence[str], behind: float) -> Figure:
    """Return the orbits of the cells along the only axis in the space of their first states.

    Parameters
    ----------
    texts : sequence of str
        What the cells are called, and what they do.
    behind : float
        Time from which on an orbit counts as what it comes to, and is drawn dark.
    """
    with style():
        figure = Figure(figsize=(PAGE, BOX))
        places = GridSpec(1, len(texts), figure, left=0.0, right=0.93, bottom=0.08, top=0.86, wspace=0.22)
        handles: dict[str, Artist] = {}
        for i, text in enumerate(texts):
            settled = int(result["region"][i]) == Region.SINK and result["time"][-1] > result["settle_time"][i]
            end = result["equilibrium"][i] if settled else None
            trace = Trace(result.sweep.model, result["time"], result["orbit"][i], behind, end)
            axes = draw_space(figure, places[i], trace, legend=False)
            axes.patch.set_visible(False)  # it would hide the label of the box beside it
            axes.set_title(text, y=1.0, color=COLOURS[i], weight="bold")
            handles |= {str(handle.get_label()): handle for handle in space_handles(trace)}
        figure.legend(handles=list(handles.values()), ncols=len(handles), loc="upper center", **LOOK)
    return figure
