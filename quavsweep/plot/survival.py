"""Survival: the share of starts that have not settled, against time, with the exponential that was fitted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from quavsweep.errors import ConfigError
from quavsweep.plot.colour import Limits
from quavsweep.plot.legend import legend_above, legend_height
from quavsweep.plot.style import PANEL, line_colours, measured, number, symbol, unit_text, with_unit
from quavsweep.reduction import survival_of

if TYPE_CHECKING:
    from quavsweep.result import Result

SURVIVAL = "survival"  # the name that a user asks for
MOST = 6  # points in a figure
WIDTH = 2.9  # inches of a legend
TITLE = "mean lifetime of chaos"
TITLE_HEIGHT = 0.16  # inches of a line
LEAST = 10  # starts that are chaotic beyond t0, of points that are chosen first


def make_survival_figure(result: Result, limits: Limits | None) -> Figure:
    """Return the survival of the starts of a few parameter points, chosen evenly among those with chaos.

    Raises
    ------
    ConfigError
        If the sweep has no ensemble.
    """
    if "lifetime" not in result:
        raise ConfigError("survival needs an ensemble of starts", possible="axes: {ensemble: {num, seed, box}}")
    chosen = _chosen(result)
    colours = line_colours(len(chosen))
    handles = [
        Line2D([], [], color=colour, label=_text(result, where)) for where, colour in zip(chosen, colours, strict=True)
    ]
    handles.append(Line2D([], [], color="0.4", ls="--", marker="|", markevery=[0], label="exponential beyond $t_0$"))
    title = TITLE + _choice(result, len(chosen))
    height = PANEL[1] + legend_height(handles, WIDTH) + TITLE_HEIGHT * (1 + title.count("\n"))
    figure = Figure(figsize=(PANEL[0], height), layout="constrained")
    axes = figure.subplots()
    for where, colour in zip(chosen, colours, strict=True):
        _draw(axes, result, where, colour)
    axes.set(yscale="log", xlim=(0.0, None))
    axes.set_ylim(*(limits or (max(axes.get_ylim()[0], 0.5 / result["starts"].max()), 1.15)))
    axes.set_xlabel(with_unit("$t$", result.sweep.model.time_unit))
    axes.set_ylabel("share of starts that have not settled")
    legend_above(axes, handles, WIDTH, title=title)
    return figure


def _candidates(result: Result) -> np.ndarray:
    """Return the numbers of the parameter points with chaos beyond t0, or of all if there are none."""
    chaotic = np.nan_to_num(result["chaotic_share"] * result["starts"]).ravel()
    candidates = np.flatnonzero(chaotic >= LEAST)
    return candidates if candidates.size else np.arange(chaotic.size)


def _chosen(result: Result) -> list[tuple[int, ...]]:
    """Return the indices of a few parameter points."""
    shape, candidates = result["starts"].shape, _candidates(result)
    picked = np.unique(np.linspace(0, candidates.size - 1, MOST).round().astype(int))
    return [tuple(int(i) for i in np.unravel_index(candidates[p], shape)) for p in picked]


def _choice(result: Result, shown: int) -> str:
    """Return which of the parameter points are shown, if not all."""
    every, with_chaos = result["starts"].size, _candidates(result).size
    if shown == every:
        return ""
    among = "evenly chosen" if shown < with_chaos else "those"
    if with_chaos < every:
        among += f"{f' of the {with_chaos}' if shown < with_chaos else ''} with $\\geq {LEAST}$ starts beyond $t_0$"
    return f", {shown} of {every} points:\n{among}"


def _draw(axes: Axes, result: Result, where: tuple[int, ...], colour: str) -> None:
    """Draw the starts of a point as steps from look to look, and the exponential from t0 on."""
    clock = result.sweep.clock
    segment = clock.segment_steps * clock.dt
    names = ("region", "time_used", "settle_time")
    cell = {name: result.part(name, _part(result, name, where)).ravel() for name in names}
    survival, _ = survival_of(cell, segment)
    share = survival.remaining
    time = segment * np.arange(len(share))
    axes.plot(time, np.where(share > 0, share, np.nan), color=colour, drawstyle="steps-post")
    first = round(float(result["lifetime_after"][where]) / segment) if len(share) > 1 else 0
    residual = float(result["lifetime"][where]) - first * segment
    if math.isfinite(residual) and residual > 0:
        late = time[first:]
        fitted = share[first] * np.exp(-(late - late[0]) / residual)
        axes.plot(late, fitted, color=colour, ls="--", lw=0.8, marker="|", ms=9, markevery=[0])


def _part(result: Result, name: str, where: tuple[int, ...]) -> tuple[int | slice, ...]:
    """Return which part of a variable belongs to a point."""
    starts, index = result.sweep.start_axes, iter(where)
    return tuple(slice(None) if axis.name in starts else next(index) for axis in result.sweep.grid.axes)


def _text(result: Result, where: tuple[int, ...]) -> str:
    """Return the parameters of a point, and its mean lifetime or the bound of it."""
    model = result.sweep.model
    values = [
        f"{symbol(model, name)[1:-1]} = {number(value)}"
        for axis, i in zip(result.sweep.points.axes, where, strict=True)
        for name, value in axis.at(i).items()
    ]
    mean, error, least = (float(result[n][where]) for n in ("lifetime", "lifetime_se", "lifetime_at_least"))
    unit = unit_text(model.time_unit)
    if math.isfinite(mean):
        told = f"${measured(mean, error)}$"
    else:
        told = f"$> {number(float(f'{least:.2g}'))}$" if math.isfinite(least) else "none"
    told += rf" ${unit}$" if unit and told != "none" else ""
    return (f"${', '.join(values)}$: " if values else "") + told
