"""Maps: quantities over the two axes of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colorbar import Colorbar
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from quavsweep.plot.along import drawn_axes
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.code import VOID, code_handles, mask_handles
from quavsweep.plot.colour import ColourScale, Limits, choose_scale
from quavsweep.plot.legend import legend_above, legend_height, legend_outside
from quavsweep.plot.overlay import Curve, draw_curves, make_curves
from quavsweep.plot.quantity import Quantity
from quavsweep.plot.scale import drawn_range, edges, set_power, set_scale
from quavsweep.plot.style import PANEL, power_of, set_room

if TYPE_CHECKING:
    from quavsweep.result import Result

ROOM = 0.06  # inches around panels
WIDTH = 2.9  # inches of a legend above a map


def make_map_figure(result: Result, variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]) -> Figure:
    """Return maps of some variables, by default of the region and the largest exponent, with curves over them."""
    catalogue = Catalogue(result)
    quantities = [catalogue.find(name) for name in variables or default_variables(result)]
    (curves,) = make_curves(overlays, [result.sweep])
    columns = min(2, len(quantities))
    rows = -(-len(quantities) // columns)
    height = PANEL[1] * rows + legend_height([curve.handle for curve in curves], PANEL[0] * columns)
    figure = Figure(figsize=(PANEL[0] * columns, height), layout="constrained")
    set_room(figure, ROOM)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, quantity in zip(grid, quantities, strict=False):
        draw_panel(figure, axes, result, quantity, choose_scale([quantity], limits), curves)
    for axes in grid[len(quantities) :]:
        axes.remove()
    legend_outside(figure, [curve.handle for curve in curves], "lower")
    return figure


def default_variables(result: Result) -> tuple[str, ...]:
    """Return what is drawn of a result with two axes if nothing is asked for."""
    if "lifetime" in result:
        error = ("lifetime_error",) if np.isfinite(result["lifetime"]).any() else ()
        return ("lifetime", *error, "chaotic_share", "basin_share.sink")
    if "attractor" in result and not result.sweep.points.axes:
        return ("attractor",)
    return ("region", "lyapunov") if "lyapunov" in result else ("region",)


def draw_panel(
    figure: Figure, axes: Axes, result: Result, quantity: Quantity, scale: ColourScale, curves: Sequence[Curve] = ()
) -> None:
    """Draw one map with its curves, and its legend or colour bar."""
    mesh = draw_map(axes, result, quantity, scale)
    draw_curves(axes, curves)
    if quantity.codes:
        legend_above(axes, code_handles(quantity.values, quantity.codes, quantity.todo), WIDTH)
        return
    legend_above(axes, number_handles(quantity), WIDTH, title=quantity.label() if quantity.empty else "")
    if not quantity.empty:
        draw_bar(figure, mesh, [axes], quantity, scale)


def number_handles(quantity: Quantity) -> list[Artist]:
    """Return a legend's entries for cells of a map of numbers that have none, or a bound alone."""
    handles = mask_handles(quantity.todo, quantity.void)
    if quantity.bounded:
        handles.append(Line2D([], [], ls="", marker=".", ms=4, mew=0.3, mec="white", color="black", label="at least"))
    return handles


def draw_map(axes: Axes, result: Result, quantity: Quantity, scale: ColourScale) -> QuadMesh:
    """Draw one value per cell, the first axis of the sweep to the right, the second upward.

    Cells that are not computed are hatched, cells without a number dark grey.
    """
    across, up = drawn_axes(result.sweep)
    order = np.ix_(np.argsort(across.values), np.argsort(up.values))
    bound = np.full(quantity.todo.shape, np.nan) if quantity.bound is None else quantity.bound
    bounded = np.isfinite(bound)
    filled, empty = np.where(bounded, bound, quantity.values), quantity.void & ~bounded
    values, todo, void = (array[order].T for array in (filled, quantity.todo, empty))
    borders = edges(np.sort(across.values)), edges(np.sort(up.values))
    axes.set_facecolor("white")
    if todo.any():
        axes.patch.set(hatch="////", edgecolor="0.6")
    if void.any():
        axes.pcolormesh(*borders, np.ma.masked_where(~void, void), cmap=ListedColormap([VOID]), rasterized=True)
    shown = np.ma.masked_where(todo | void, values)
    mesh = axes.pcolormesh(*borders, shown, rasterized=True, cmap=scale.colours, norm=scale.norm)
    if bounded.any():
        x, y = (np.asarray(axis.values)[i] for axis, i in zip((across, up), np.nonzero(bounded), strict=True))
        axes.plot(x, y, ls="", marker=".", ms=2.0, mew=0.3, mec="white", color="black")
    set_scale(axes.xaxis, result.sweep.model, across)
    set_scale(axes.yaxis, result.sweep.model, up)
    axes.set(xlim=drawn_range(across), ylim=drawn_range(up))
    return mesh


def draw_bar(
    figure: Figure, mesh: QuadMesh, panels: Sequence[Axes], quantity: Quantity, scale: ColourScale
) -> Colorbar:
    """Draw a colour bar with the quantity's name and unit; a common power of ten goes into the label."""
    power = 0 if quantity.log else power_of(np.array([scale.norm.vmin, scale.norm.vmax]))
    bar = figure.colorbar(mesh, ax=list(panels), extend=scale.extend, aspect=25, pad=0.02)
    bar.set_label(quantity.label(power))
    if not quantity.log:
        set_power(bar.ax.yaxis, power)
    if scale.ticks:
        texts = [f"{value / 10.0**power:.3g}".replace("-", "\N{MINUS SIGN}") for value in scale.ticks]
        bar.set_ticks(scale.ticks, labels=texts)
    if not quantity.log:
        bar.ax.minorticks_off()
    return bar
