"""Orbit diagrams of a state and of what is computed from it, under strips that tell the regions along the axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from quavsweep.plot.along import drawn_axes
from quavsweep.plot.legend import legend_height, legend_outside
from quavsweep.plot.orbit_diagram import SIZES, WIDTH
from quavsweep.plot.scale import drawn_range, set_scale, set_values
from quavsweep.plot.strip import HEIGHT, Strips, draw_strips, strip_handles
from quavsweep.plot.style import PAGE

if TYPE_CHECKING:
    from quavsweep.result import Result

PANEL_HEIGHT = 1.9  # inches
FOOT = 0.4


@dataclass(frozen=True)
class Dots:
    """What a panel shows: several numbers of each cell, NaN for none.

    Parameters
    ----------
    values : (n, m) float64
    text, unit : str
    """

    values: np.ndarray
    text: str
    unit: str


def make_bifurcation_figure(result: Result, panels: Sequence[Dots], strips: Strips) -> Figure:
    """Return panels of dots over the only axis of a sweep, with strips on top."""
    (axis,) = drawn_axes(result.sweep)
    order = np.argsort(axis.values)
    at, handles = np.asarray(axis.values)[order], strip_handles(strips)
    heights = [HEIGHT * len(strips), *[PANEL_HEIGHT] * len(panels)]
    height = sum(heights) + FOOT + legend_height(handles, PAGE)
    figure = Figure(figsize=(PAGE, height), layout="constrained")
    top, *grid = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    draw_strips(top, at, {name: region[order] for name, region in strips.items()})
    top.tick_params(axis="x", length=0)
    size = float(np.clip(WIDTH / len(at), *SIZES))
    for axes, dots in zip(grid, panels, strict=True):
        x = np.broadcast_to(np.asarray(axis.values)[:, None], dots.values.shape)
        axes.plot(x.ravel(), dots.values.ravel(), ls="", marker="o", ms=size, mew=0, color="black", rasterized=True)
        axes.margins(y=0.06)
        set_values(axes.yaxis, dots.values, dots.text, dots.unit)
        axes.label_outer()
    grid[-1].set_xlim(*drawn_range(axis))
    set_scale(grid[-1].xaxis, result.sweep.model, axis)
    legend_outside(figure, handles, "upper")
    figure.align_ylabels(grid)
    return figure
