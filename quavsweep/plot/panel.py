"""Panels of a sweep with one axis: numbers, samples or codes along it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from quavsweep.codes import Code
from quavsweep.plot.along import drawn_axes
from quavsweep.plot.band import hatch
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.colour import Limits
from quavsweep.plot.orbit_diagram import draw_samples, sampled_state, samples_text
from quavsweep.plot.overlay import Curve, draw_marks
from quavsweep.plot.quantity import Quantity
from quavsweep.plot.scale import drawn_range, set_scale, set_values
from quavsweep.plot.style import DASHES, LINES, say

if TYPE_CHECKING:
    from quavsweep.result import Result

Panel = list[Quantity]  # the components of one variable that are drawn together
ALONE, STACKED = 2.1, 1.4  # inches of a panel by itself, and among others
PER_CODE = 0.2
MARKED = 80  # up to so many cells each has a mark
TOGETHER = 6  # components in one panel at most
SEEN, SEEN_IN = 0.01, 0.05  # errors are seen that are so large, of the range of values, in so many of the cells
ROOM = 20  # characters beside a panel
JUMPY = ("final_state",)  # variables that differ from cell to cell, drawn as dots without lines


def choose_panels(result: Result, variables: Sequence[str]) -> list[Panel]:
    """Return what is drawn in each panel."""
    catalogue = Catalogue(result, samples=True)
    if not variables:
        return [panel for name in _defaults(result) for panel in _grouped(catalogue.parts(name))]
    return [panel for name in variables for panel in _grouped(catalogue.parts(name))]


def _defaults(result: Result) -> Iterator[str]:
    """Yield the variables that say most of the orbits."""
    if "lifetime" in result:
        yield from ("lifetime", "chaotic_share", "basin_share")
        return
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


def panel_height(panel: Panel, count: int) -> float:
    """Return the height in inches of a panel among so many."""
    if panel[0].codes:
        return PER_CODE * (1 + len(_present(panel[0])))
    return STACKED if count > 1 else ALONE


def draw_panel(
    axes: Axes, result: Result, panel: Panel, limits: Limits | None = None, curves: Sequence[Curve] = ()
) -> None:
    """Draw quantities along the axis of a sweep, each as what it is."""
    (axis,) = drawn_axes(result.sweep)
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
        set_values(axes.yaxis, shown, text, first.unit, ROOM, log=first.log)
        if not np.isfinite(shown).any():
            axes.set_yticks([])
            say(axes, "no value")
        if limits is not None:
            axes.set_ylim(*limits)
    draw_marks(axes, curves)
    hatch(axes, result, first.todo)
    axes.set_xlim(*drawn_range(axis))
    set_scale(axes.xaxis, result.sweep.model, axis)


def _draw_lines(axes: Axes, result: Result, panel: Panel) -> np.ndarray:
    """Draw numbers against the axis, with bands of their standard errors, and return all numbers."""
    (axis,) = drawn_axes(result.sweep)
    order = np.argsort(axis.values)
    x = np.asarray(axis.values)[order]
    jumpy = _is_jumpy(panel)
    shown: np.ndarray = np.stack([quantity.shown[order] for quantity in panel])
    for i, (quantity, y) in enumerate(zip(panel, shown, strict=True)):
        colour, dashes = LINES[i % len(LINES)], "" if jumpy else DASHES[i % len(DASHES)]
        marked = np.isfinite(y) if jumpy else _alone(y)
        axes.plot(x, quantity.values[order], color=colour, ls=dashes, marker=".", ms=2.5, markevery=marked)
        if quantity.log:
            shown[i] = _draw_bounded(axes, x, quantity, order, colour)
        elif quantity.error is not None:
            error = np.where(np.isfinite(quantity.error[order]), quantity.error[order], 0.0)
            axes.fill_between(x, y - error, y + error, color=colour, alpha=0.3, linewidth=0)
    if panel[0].rate:
        axes.axhline(0.0, color="0.3", lw=0.5, ls=":", zorder=0.5)
    axes.margins(y=0.12)
    if panel[0].share:
        axes.set_ylim(-0.03, 1.03)
    return shown


def _draw_bounded(axes: Axes, x: np.ndarray, quantity: Quantity, order: np.ndarray, colour: str) -> np.ndarray:
    """Draw bars of errors on a logarithmic axis, and arrows at bounds; return numbers and bounds."""
    axes.set_yscale("log")
    y, error = quantity.shown[order], quantity.error
    if error is not None:
        low = np.minimum(error[order], 0.9 * y)
        axes.errorbar(x, y, [low, error[order]], ls="", color=colour, elinewidth=0.8, capsize=1.5)
    if quantity.bound is None:
        return np.asarray(y)
    bound = quantity.bound[order]
    axes.plot(x, bound, ls="", marker="^", ms=3, mfc="white", mec=colour, mew=0.6)
    return np.asarray(np.where(np.isfinite(y), y, bound))


def _is_jumpy(panel: Panel) -> bool:
    return panel[0].name.partition(".")[0] in JUMPY


def _alone(y: np.ndarray) -> np.ndarray:
    """Return which numbers need a mark of their own: all where they are few, else those without neighbours."""
    known: np.ndarray = np.isfinite(y)
    if len(y) <= MARKED:
        return known
    beside = np.concatenate([[False], known[:-1]]) | np.concatenate([known[1:], [False]])
    return np.asarray(known & ~beside)


def _draw_codes(axes: Axes, result: Result, quantity: Quantity) -> None:
    """Draw codes as coloured boxes on a line for each code that is present."""
    (axis,) = drawn_axes(result.sweep)
    present = _present(quantity)
    for level, code in enumerate(present):
        x = np.asarray(axis.values)[~quantity.todo & (quantity.values == code.number)]
        axes.plot(x, np.full(len(x), level), ls="", marker="s", ms=3, mec="black", mew=0.2, color=code.colour)
    axes.set_yticks(range(len(present)), [code.meaning for code in present])
    axes.set_ylim(-0.5, max(len(present), 1) - 0.5)


def _present(quantity: Quantity) -> list[Code]:
    """Return the codes that some computed cell has."""
    return [code for code in quantity.codes if (~quantity.todo & (quantity.values == code.number)).any()]


def panel_handles(panel: Panel) -> list[Artist]:
    """Return a legend's lines for the components of a variable, none if there is only one."""
    if panel[0].bounded:
        mean = Line2D([], [], color=LINES[0], marker=".", ms=2.5, label="mean \N{PLUS-MINUS SIGN} standard error")
        bound = Line2D([], [], ls="", marker="^", ms=3, mfc="white", mec=LINES[0], mew=0.6, label="at least (95 %)")
        return [mean, bound] if np.isfinite(panel[0].shown).any() else [bound]
    if len(panel) == 1:
        return []
    jumpy = _is_jumpy(panel)
    marks = [{"ls": "", "marker": "."} if jumpy else {"ls": dashes} for dashes in DASHES]
    handles: list[Artist] = [
        Line2D([], [], color=LINES[i % len(LINES)], label=quantity.part, **marks[i % len(marks)])
        for i, quantity in enumerate(panel)
    ]
    if _errors_are_seen(panel):
        handles.append(Patch(facecolor="0.7", linewidth=0, label="\N{PLUS-MINUS SIGN} standard error"))
    return handles


def _errors_are_seen(panel: Panel) -> bool:
    """Whether standard errors can be seen beside the numbers."""
    shown = np.stack([quantity.shown for quantity in panel])
    errors = np.stack([np.zeros_like(q.shown) if q.error is None else q.error for q in panel])
    span = np.ptp(shown[np.isfinite(shown)]) if np.isfinite(shown).any() else np.inf
    return float(np.mean(np.isfinite(errors) & (errors > SEEN * span))) > SEEN_IN
