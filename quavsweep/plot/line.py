"""Figures of a sweep with one axis: panels under each other, below a band that shows the regions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from quavsweep.plot.band import band_handles, draw_band, hatch
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.colour import Limits
from quavsweep.plot.legend import LOOK, legend_above, legend_height
from quavsweep.plot.orbit_diagram import draw_samples, sampled_state, samples_text
from quavsweep.plot.overlay import Curve, draw_marks, make_curves
from quavsweep.plot.quantity import Quantity
from quavsweep.plot.scale import drawn_range, set_scale, set_values
from quavsweep.plot.style import DASHES, LINES, PANEL

if TYPE_CHECKING:
    from quavsweep.result import Result

Panel = list[Quantity]  # the components of one variable that are drawn together
STACKED = 1.5  # inches of a panel among others
FOOT = 0.45  # inches for the label of the axis
WIDTH = 2.9  # inches of the legend
MARKED = 80  # up to so many cells each has a mark
TOGETHER = 6  # components in one panel at most


def make_line_figure(
    result: Result, variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]
) -> Figure:
    """Return panels of some variables along the axis, by default what says most of the orbits."""
    panels = choose_panels(result, variables)
    (curves,) = make_curves(overlays, [result.sweep])
    lines = [panel for panel in panels if len(panel) > 1]
    handles = [*(line_handles(lines[0]) if len(lines) == 1 else []), *band_handles(result)]
    handles += [curve.handle for curve in curves]
    single = len(panels) == 1
    height = PANEL[1] if single else STACKED * len(panels) + FOOT + legend_height(handles, WIDTH)
    figure = Figure(figsize=(PANEL[0], height), layout="constrained")
    grid = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(grid, panels, strict=True):
        draw_panel(axes, result, panel, limits, curves)
        axes.label_outer()
        if len(panel) > 1 and len(lines) > 1:
            axes.legend(handles=line_handles(panel), loc="center left", bbox_to_anchor=(1.0, 0.5), **LOOK)
    top = draw_band(grid[0], result, 2.0 if single else STACKED)
    legend_above(grid[0], handles, WIDTH, top)
    figure.align_ylabels()
    return figure


def choose_panels(result: Result, variables: Sequence[str]) -> list[Panel]:
    """Return what is drawn in each panel."""
    catalogue = Catalogue(result, samples=True)
    if not variables:
        return [panel for name in _defaults(result) for panel in _grouped(catalogue.parts(name))]
    return [panel for name in variables for panel in _grouped(catalogue.parts(name))]


def _defaults(result: Result) -> Iterator[str]:
    """Yield the variables that say most of the orbits."""
    if "samples" in result:
        yield f"samples.{sampled_state(result.sweep)}"
    if "lyapunov" in result:
        yield "lyapunov"
    elif "samples" not in result:
        others = [name for name in ("peak", "first_time") if name in result]
        yield from others or ["final_state"]


def _grouped(quantities: list[Quantity]) -> Iterator[Panel]:
    """Yield the components that share a panel: numbers of one unit, a few at a time."""
    for unit in dict.fromkeys(quantity.unit for quantity in quantities):
        same = [quantity for quantity in quantities if quantity.unit == unit]
        together = 1 if same[0].sampled or same[0].codes else TOGETHER
        yield from (same[i : i + together] for i in range(0, len(same), together))


def draw_panel(
    axes: Axes, result: Result, panel: Panel, limits: Limits | None = None, curves: Sequence[Curve] = ()
) -> None:
    """Draw quantities along the axis of a sweep, each as what it is."""
    (axis,) = result.sweep.grid.axes
    first = panel[0]
    if first.codes:
        _draw_codes(axes, result, first)
    else:
        text = Catalogue(result, samples=True).group_text(panel)
        if first.sampled:
            shown = draw_samples(axes, result, first)
            text = samples_text(result, first) if first.name.startswith("samples.") else text
        else:
            shown = _draw_lines(axes, result, panel)
        set_values(axes.yaxis, shown, text, first.unit)
        if not np.isfinite(shown).any():
            _say_empty(axes)
        if limits is not None:
            axes.set_ylim(*limits)
    draw_marks(axes, curves)
    hatch(axes, result, first.todo)
    axes.set_xlim(*drawn_range(axis))
    set_scale(axes.xaxis, result.sweep.model, axis)


def _draw_lines(axes: Axes, result: Result, panel: Panel) -> np.ndarray:
    """Draw numbers against the axis, with bands of their standard errors, and return all numbers."""
    (axis,) = result.sweep.grid.axes
    order = np.argsort(axis.values)
    x = np.asarray(axis.values)[order]
    shown: np.ndarray = np.stack([quantity.shown[order] for quantity in panel])
    for i, (quantity, y) in enumerate(zip(panel, shown, strict=True)):
        colour, dashes = LINES[i % len(LINES)], DASHES[i % len(DASHES)]
        axes.plot(x, quantity.values[order], color=colour, ls=dashes, marker=".", ms=2.5, markevery=_alone(y))
        if quantity.error is not None:
            error = np.where(np.isfinite(quantity.error[order]), quantity.error[order], 0.0)
            axes.fill_between(x, y - error, y + error, color=colour, alpha=0.3, linewidth=0)
    if panel[0].rate:
        axes.axhline(0.0, color="0.3", lw=0.5, ls=":", zorder=0.5)
    axes.margins(y=0.12)
    return shown


def _alone(y: np.ndarray) -> np.ndarray:
    """Return which numbers need a mark of their own: all where they are few, else those without neighbours."""
    known: np.ndarray = np.isfinite(y)
    if len(y) <= MARKED:
        return known
    beside = np.concatenate([[False], known[:-1]]) | np.concatenate([known[1:], [False]])
    return np.asarray(known & ~beside)


def _draw_codes(axes: Axes, result: Result, quantity: Quantity) -> None:
    """Draw codes as coloured boxes on a line for each code that is present."""
    (axis,) = result.sweep.grid.axes
    present = [code for code in quantity.codes if (~quantity.todo & (quantity.values == code.number)).any()]
    for level, code in enumerate(present):
        x = np.asarray(axis.values)[~quantity.todo & (quantity.values == code.number)]
        axes.plot(x, np.full(len(x), level), ls="", marker="s", ms=3, mec="black", mew=0.2, color=code.colour)
    axes.set_yticks(range(len(present)), [code.meaning for code in present])
    axes.set_ylim(-0.5, max(len(present), 1) - 0.5)


def _say_empty(axes: Axes) -> None:
    """Say that a panel has no numbers, instead of showing an axis without meaning."""
    axes.set_yticks([])
    axes.text(0.5, 0.5, "no value", transform=axes.transAxes, ha="center", va="center", color="0.3")


def line_handles(panel: Panel) -> list[Artist]:
    """Return a legend's lines for the components of a variable."""
    handles: list[Artist] = [
        Line2D([], [], color=LINES[i % len(LINES)], ls=DASHES[i % len(DASHES)], label=quantity.part)
        for i, quantity in enumerate(panel)
    ]
    if any(quantity.error is not None and _visible(quantity) for quantity in panel):
        handles.append(Patch(facecolor="0.7", linewidth=0, label="\N{PLUS-MINUS SIGN} standard error"))
    return handles


def _visible(quantity: Quantity) -> bool:
    """Whether standard errors can be seen beside the numbers."""
    assert quantity.error is not None
    shown, error = quantity.shown, quantity.error
    span = np.ptp(shown[np.isfinite(shown)]) if np.isfinite(shown).any() else 0.0
    return bool((error[np.isfinite(error)] > 0.02 * span).any())
