"""Figures of a sweep with one axis: panels under each other, below a band that shows the regions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from quavsweep.plot.band import band_handles, draw_band
from quavsweep.plot.colour import Limits
from quavsweep.plot.legend import legend_above, legend_height
from quavsweep.plot.overlay import make_curves
from quavsweep.plot.panel import choose_panels, draw_panel, panel_handles, panel_height
from quavsweep.plot.style import PANEL

if TYPE_CHECKING:
    from quavsweep.result import Result

FOOT = 0.45  # inches for the label of the axis
WIDTH = 2.9  # inches of a legend


def make_line_figure(
    result: Result, variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]
) -> Figure:
    """Return panels of some variables along the axis, by default what says most of the orbits."""
    panels = choose_panels(result, variables)
    (curves,) = make_curves(overlays, [result.sweep])
    handles = [panel_handles(panel) for panel in panels]
    handles[0] += [*(band_handles(result) if "region" in result else []), *(curve.handle for curve in curves)]
    heights = [panel_height(panel, len(panels)) for panel in panels]
    height = sum(heights) + FOOT + sum(legend_height(own, WIDTH) for own in handles)
    figure = Figure(figsize=(PANEL[0], max(height, PANEL[1])), layout="constrained")
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for axes, panel in zip(grid, panels, strict=True):
        draw_panel(axes, result, panel, limits, curves)
        axes.label_outer()
    top = draw_band(grid[0], result, heights[0]) if "region" in result else 1.0
    for axes, own, base in zip(grid, handles, [top, *[1.0] * len(panels)], strict=False):
        legend_above(axes, own, WIDTH, base)
    figure.align_ylabels()
    return figure
