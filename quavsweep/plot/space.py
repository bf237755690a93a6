"""Orbits in the space, or the plane, of their first states."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D

from quavsweep.models import Model
from quavsweep.plot.decimate import MOST_ORBIT, strided
from quavsweep.plot.legend import LOOK
from quavsweep.plot.scale import set_power
from quavsweep.plot.style import label, power_of
from quavsweep.plot.trace import EARLY, LATE, MARK, Trace

ZOOM = 1.0  # of a box in three dimensions, so that its labels have room


def space_dimensions(model: Model) -> int:
    """Return how many states the picture of an orbit in space has: three, two, or none if there is only one."""
    count = len(model.states)
    return min(count, 3) if count > 1 else 0


def draw_space(figure: Figure, place: SubplotSpec, trace: Trace, legend: bool = True) -> Axes:
    """Draw an orbit: its early part pale, its late part dark, its start, and the equilibrium in which it ends."""
    count = space_dimensions(trace.model)
    axes = figure.add_subplot(place, projection="3d" if count == 3 else None)
    states = trace.shown[:, :count]
    early, late = states[: trace.late + 1], states[trace.late :][-MOST_ORBIT:]
    axes.plot(*early[strided(len(early))].T, color=EARLY, lw=0.4, rasterized=True)
    axes.plot(*late.T, color=LATE, lw=0.4, rasterized=True)
    start, end = _marks(trace)
    axes.plot(*states[:1].T, **start)
    if end:
        axes.plot(*np.asarray(trace.equilibrium)[:count, None], **end)
    (_label_box if count == 3 else _label_plane)(axes, trace.model, states)
    where = "upper center" if count == 3 else "lower center"
    if legend:
        above = (0.5, 1.08 if count == 3 else 1.0)
        axes.legend(handles=space_handles(trace), loc=where, bbox_to_anchor=above, ncols=4, **LOOK)
    return axes


def _marks(trace: Trace) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return how start and equilibrium are marked; the latter is empty if the orbit does not end in one."""
    start = {"marker": "o", "ms": 3.5, "color": "white", "mec": "black", "mew": 0.8, "ls": "", "label": "start"}
    end = {"marker": "D", "ms": 4.0, "color": MARK, "mec": "black", "mew": 0.6, "ls": "", "label": "equilibrium"}
    return start, end if trace.equilibrium is not None else {}


def space_handles(trace: Trace) -> list[Artist]:
    """Return a legend's entries for the parts of an orbit and its marks."""
    parts = zip(trace.part_names, (EARLY, LATE), strict=True)
    lines = [Line2D([], [], color=colour, lw=1.2, label=name) for name, colour in parts]
    return [*lines[0 if trace.late else 1 :], *(Line2D([], [], **mark) for mark in _marks(trace) if mark)]


def _label_plane(axes: Axes, model: Model, states: np.ndarray) -> None:
    """Label the axes of a plane."""
    for i, axis in enumerate((axes.xaxis, axes.yaxis)):
        _label(axis, model, states, i)


def _label_box(axes: Any, model: Model, states: np.ndarray) -> None:
    """Label the axes of a box, quietly drawn, and leave room for the labels.

    The layout of figures knows nothing of them.
    """
    for i, axis in enumerate((axes.xaxis, axes.yaxis, axes.zaxis)):
        _label(axis, model, states, i)
        axis.get_major_locator().set_params(nbins=4)
        axis.labelpad = -1
        axis.pane.set(facecolor="white", edgecolor="0.8")
        axis._axinfo["grid"].update(color="0.88", linewidth=0.4)
    axes.tick_params(pad=-3)
    axes.set_box_aspect((1.0, 1.0, 0.8), zoom=ZOOM)
    axes.zaxis.labelpad = -5
    axes.set_anchor((0.3, 0.5))
    axes.set_in_layout(False)


def _label(axis: Any, model: Model, states: np.ndarray, index: int) -> None:
    power = power_of(states[:, index])
    set_power(axis, power)
    axis.set_label_text(label(model, model.states[index].name, power))
