"""Maps of the regions at two times beside each other, with what explains the difference, and strips below."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.plot.along import drawn_axes
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.code import code_handles
from quavsweep.plot.colour import choose_scale
from quavsweep.plot.legend import legend_height, legend_outside
from quavsweep.plot.map import draw_bar, draw_map, number_handles
from quavsweep.plot.overlay import Curve, draw_curves
from quavsweep.plot.scale import drawn_range, set_scale
from quavsweep.plot.strip import HEIGHT, Strips, draw_strips
from quavsweep.plot.style import PAGE, unit_text

if TYPE_CHECKING:
    from quavsweep.result import Result

MAP_HEIGHT = {2: 2.9, 3: 2.5}  # inches, of so many maps
FOOT = 0.55


def time_text(result: Result) -> str:
    """Return up to which time a result tells, as `40,000 s`."""
    clock = result.sweep.clock
    end = result.horizon if result.horizon is not None else result.sweep.most_steps * clock.dt
    unit = unit_text(result.sweep.model.time_unit)
    return f"{end:,.0f}" + (rf" ${unit}$" if unit else "")


def make_twice_figure(
    results: Sequence[Result],
    curves: Sequence[Curve] = (),
    lifetime: Result | None = None,
    strips: tuple[Result, Strips, str] | None = None,
) -> Figure:
    """Return maps of the region of some results over one plane, a map of lifetimes, and strips over another line.

    Parameters
    ----------
    results : sequence of Result
        The same sweep at several times.
    curves : sequence of Curve
        Drawn over each map.
    lifetime : Result, optional
        Over the parameter points of an ensemble.
    strips : (Result, dict, str), optional
        A sweep with one axis, what is told of its regions, and the title of that.
    """
    quantities = [Catalogue(result).find("region") for result in results]
    shown = [*quantities, *([Catalogue(strips[0]).find("region")] if strips else [])]
    values, todo = (np.concatenate([getattr(q, name).ravel() for q in shown]) for name in ("values", "todo"))
    above, below = code_handles(values, quantities[0].codes, todo), [curve.handle for curve in curves]
    if lifetime is not None:
        mean = Catalogue(lifetime).find("lifetime")
        above += number_handles(mean)
    columns = len(results) + (lifetime is not None)
    rows = [MAP_HEIGHT[columns], *([HEIGHT * len(strips[1]) + FOOT] if strips else [])]
    height = sum(rows) + legend_height(above, PAGE) + legend_height(below, PAGE)
    figure = Figure(figsize=(PAGE, height), layout="constrained")
    grid = figure.add_gridspec(len(rows), columns, height_ratios=rows)
    for i, (result, quantity) in enumerate(zip(results, quantities, strict=True)):
        axes = figure.add_subplot(grid[0, i])
        draw_map(axes, result, quantity, choose_scale(quantities, None))
        _finish(axes, i, f"({chr(97 + i)}) region at {time_text(result)}", curves)
    if lifetime is not None:
        axes, scale = figure.add_subplot(grid[0, -1]), choose_scale([mean], None)
        draw_bar(figure, draw_map(axes, lifetime, mean, scale), [axes], mean, scale)
        _finish(axes, columns - 1, f"({chr(96 + columns)}) mean lifetime of chaos", curves)
        axes.set(xlim=figure.axes[0].get_xlim(), ylim=figure.axes[0].get_ylim())
    if strips:
        line, rows_of_it, title = strips
        _draw_line(figure.add_subplot(grid[1, :]), line, rows_of_it, f"({chr(97 + columns)}) {title}")
    legend_outside(figure, above, "upper")
    legend_outside(figure, below, "lower")
    return figure


def _finish(axes: Axes, column: int, title: str, curves: Sequence[Curve]) -> None:
    """Draw the curves of a map, and leave out a label that stands on its left neighbour already."""
    draw_curves(axes, curves)
    axes.set_title(title)
    if column:
        axes.set_ylabel("")
        axes.tick_params(labelleft=False)


def _draw_line(axes: Axes, result: Result, strips: Strips, title: str) -> None:
    """Draw the strips of a sweep along its only axis."""
    (axis,) = drawn_axes(result.sweep)
    order = np.argsort(axis.values)
    draw_strips(axes, np.asarray(axis.values)[order], {name: region[order] for name, region in strips.items()})
    axes.set_xlim(*drawn_range(axis))
    set_scale(axes.xaxis, result.sweep.model, axis)
    axes.set_title(title)
