"""Figures of a sweep without axes: its orbit, its return plot, or its numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from quavsweep.codes import REGION, Region
from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.colour import Limits
from quavsweep.plot.observed import observed
from quavsweep.plot.orbit import add_orbit, orbit_height
from quavsweep.plot.orbit_diagram import sampled_state, samples_text
from quavsweep.plot.overlay import make_curves
from quavsweep.plot.scale import set_values
from quavsweep.plot.series import draw_course
from quavsweep.plot.style import PANEL, measured, number, rate_unit, say, symbol, unit_text, with_unit
from quavsweep.plot.title import LINE, cell_title, horizon_text
from quavsweep.plot.trace import Trace

if TYPE_CHECKING:
    from quavsweep.result import Result

WRITTEN = 0.16  # inches of a line
WRITTEN_OUT = 3  # exponents at most whose values fit beside each other
ROOM = 30  # characters beside a course
FEW = 300  # samples up to which dots are large


def make_cell_figure(
    result: Result, variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]
) -> Figure:
    """Return the orbit and the return plot of the only cell, or its exponents if neither was recorded."""
    make_curves(overlays, [result.sweep])
    shown = _chosen(result, variables)
    if int(result["region"]) == Region.NONE:
        return _nothing(result)
    others = [part for part in shown if part != "orbit"]
    trace = _trace(result) if "orbit" in shown else None
    columns = 2 if trace or len(others) > 1 else 1
    heights = [*([orbit_height(trace)] if trace else []), *_heights(result, others, columns)]
    title = _title(result, PANEL[0] * columns)
    height = sum(heights) + LINE * (title.count("\n") + 1)
    figure = Figure(figsize=(PANEL[0] * columns, height), layout="constrained")
    figure.suptitle(title, fontsize=8)
    rows = GridSpec(len(heights), columns, figure, height_ratios=heights)
    if trace:
        add_orbit(figure, rows[0, :], trace)
    for i, part in enumerate(others, columns if trace else 0):
        draw_part(figure.add_subplot(rows[i // columns, i % columns]), result, part, limits)
    return figure


def _heights(result: Result, parts: Sequence[str], columns: int) -> list[float]:
    """Return the heights in inches of the rows of some parts; written states need little."""
    rows = [parts[i : i + columns] for i in range(0, len(parts), columns)]
    written = WRITTEN * (len(result.sweep.model.states) + 3)
    return [written if list(row) == ["final_state"] else PANEL[1] for row in rows]


def _nothing(result: Result) -> Figure:
    """Return the figure of a cell that is not computed."""
    title = _title(result, PANEL[0])
    figure = Figure(figsize=(PANEL[0], LINE * (title.count("\n") + 2)))
    figure.text(0.5, 0.5, title, ha="center", va="center")
    return figure


def region_text(result: Result) -> str:
    """Return what the orbit of the only cell does in the end."""
    return REGION[int(result["region"])].meaning


def default_parts(result: Result) -> list[str]:
    """Return what is drawn of a result without axes if nothing is asked for."""
    possible = possible_parts(result)
    if "orbit" in possible and "samples" in possible:
        return possible[:3]
    return possible[:1]


def possible_parts(result: Result) -> list[str]:
    """Return what can be drawn of a result without axes."""
    return [*(name for name in ("orbit", "samples", "lyapunov") if name in result), "final_state"]


def _courses(result: Result) -> list[str]:
    """Return the states and observables that can be drawn against time."""
    model = result.sweep.model
    return [f"orbit.{name}" for name in (*model.state_names, *model.observable_names)] if "orbit" in result else []


def _chosen(result: Result, variables: Sequence[str]) -> list[str]:
    possible = [*possible_parts(result), *_courses(result)]
    for name in variables:
        if name not in possible:
            hint = nearest(name, possible)
            raise ConfigError(f"no variable {name} to draw{hint}", possible=f"possible are {', '.join(possible)}")
    return list(variables) or default_parts(result)


def _trace(result: Result) -> Trace:
    equilibrium = result["equilibrium"] if int(result["region"]) == Region.SINK else None
    return Trace(result.sweep.model, result["time"], result["orbit"], result.sweep.clock.transient, equilibrium)


def draw_part(
    axes: Axes, result: Result, part: str, limits: Limits | None = None, written_out: int = WRITTEN_OUT
) -> None:
    """Draw a part of the only cell, such as `samples` or `orbit.p`; no more than some exponents are written out."""
    draw: dict[str, Callable[[Axes, Result], None]] = {"samples": _draw_return, "lyapunov": _draw_exponents}
    if part.startswith("orbit."):
        _draw_course(axes, result, part.partition(".")[2])
    else:
        draw.get(part, _draw_state)(axes, result)
    if part == "lyapunov" and len(result["lyapunov"]) <= written_out:
        axes.set_xticks(axes.get_xticks(), _written_out(result))
    if limits is not None and (part in draw or "." in part):
        axes.set_ylim(*limits)


def _draw_course(axes: Axes, result: Result, name: str) -> None:
    """Draw a state or observable against time."""
    trace, model = _trace(result), result.sweep.model
    known = name in model.state_names
    values = trace.shown[:, model.state_names.index(name)] if known else observed(result, "orbit", name)
    draw_course(axes, trace, values, name, ROOM)
    axes.set_xlabel(with_unit("$t$", model.time_unit))


def _draw_return(axes: Axes, result: Result) -> None:
    """Draw each sample against the one before."""
    quantity = Catalogue(result, samples=True).find(f"samples.{sampled_state(result.sweep)}")
    values, text = quantity.shown, samples_text(result, quantity)
    size = 2.5 if np.isfinite(values).sum() < FEW else 1.2
    axes.plot(values[:-1], values[1:], ls="", marker="o", ms=size, mew=0, color="black", rasterized=True)
    axes.axline((0, 0), slope=1, color="0.6", lw=0.5, zorder=0.5)
    finite = values[np.isfinite(values)]
    if finite.size < 2:
        axes.set(xticks=[], yticks=[])
        say(axes, "no value")
    else:
        margin = 0.06 * np.ptp(finite) or 0.5
        axes.set(
            xlim=(finite.min() - margin, finite.max() + margin), ylim=(finite.min() - margin, finite.max() + margin)
        )
    axes.set_aspect("equal")
    set_values(axes.xaxis, values, f"{text}, $n$th", quantity.unit)
    set_values(axes.yaxis, values, f"{text}, $(n + 1)$th", quantity.unit)


def _draw_exponents(axes: Axes, result: Result) -> None:
    """Draw the exponents with bars of their standard errors."""
    values, errors = result["lyapunov"], result["lyapunov_se"]
    k = np.arange(1, len(values) + 1)
    errors = np.where(np.isfinite(errors), errors, 0.0)
    axes.errorbar(k, values, errors, ls="", marker="o", ms=3, color="black", capsize=2, elinewidth=0.8)
    axes.axhline(0.0, color="0.3", lw=0.5, ls=":", zorder=0.5)
    axes.set_xticks(k, [rf"$\lambda_{{{i}}}$" for i in k])
    axes.set_xlim(0.5, len(values) + 0.5)
    set_values(axes.yaxis, values, r"$\lambda_k$", rate_unit(result.sweep.model))


def _written_out(result: Result) -> list[str]:
    """Return the names of the exponents, with their values below."""
    pairs = zip(result["lyapunov"], result["lyapunov_se"], strict=True)
    return [rf"$\lambda_{{{k}}}$" + f"\n${measured(*pair)}$" for k, pair in enumerate(pairs, 1)]


def _draw_state(axes: Axes, result: Result) -> None:
    """Write the final state down."""
    model = result.sweep.model
    axes.set_axis_off()
    names = [f"final {symbol(model, state.name)}" for state in model.states]
    units = [unit_text(state.unit) for state in model.states]
    values = [f"$= {number(value)}\\,{unit}$" for value, unit in zip(result["final_state"], units, strict=True)]
    for x, align, texts in ((0.48, "right", names), (0.52, "left", values)):
        axes.text(x, 0.5, "\n".join(texts), transform=axes.transAxes, ha=align, va="center")


def _title(result: Result, width: float) -> str:
    initial = [result.sweep.config.initial.get(name, 0.0) for name in result.sweep.model.state_names]
    return cell_title(result.sweep, initial, int(result["region"]), width, result.fixed, horizon_text(result))
