"""The figure of a margin: along each direction what was found, both ways, and beside it what changes gain."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from quavsweep.codes import REGION
from quavsweep.plot.code import patch
from quavsweep.plot.figure import save_figure
from quavsweep.plot.legend import legend_height, legend_outside
from quavsweep.plot.style import PAGE, style, symbol, with_unit

if TYPE_CHECKING:
    from quavsweep.margin import Margin
    from quavsweep.margin.criterion import Answer
    from quavsweep.margin.finding import Gain, Line, Side

ROW = 0.27  # inches of a direction
FOOT = 0.75  # inches for the axis and its label
BAND = 0.62  # of a row, that a direction's band takes
REGIONS = {code.name: (code.colour, code.meaning) for code in REGION}
SAFE = "safe"
SHARES = {"few": 1 / 3, "many": 2 / 3, "most": 1.0}  # of starts that do not end in a sink, where the craft tumbles
FOUND = (
    {SAFE: (REGIONS["sink"][0], "safe (sink, or within the limit)")}
    | REGIONS
    | {  # what a point is drawn as, in the legend's order
        "few": ("#fdd8a2", "up to 1/3 of starts elsewhere"),
        "many": ("#e69f00", "up to 2/3 of starts elsewhere"),
        "most": ("#7f4f00", "more of the starts elsewhere"),
        "beyond": ("#cc79a7", "beyond the angle"),
        "lost": (REGIONS["unbounded"][0], "left the domain"),
    }
)
NOWHERE: dict[str, Any] = {"facecolor": "white", "edgecolor": "0.6", "hatch": "//////", "linewidth": 0.0}
CRAFT = 1.2  # points, of the line where the craft is
CHANGE: dict[str, Any] = {"marker": "D", "ms": 4, "mfc": "white", "mec": "black", "mew": 0.8}
BOUND: dict[str, Any] = {"marker": "X", "ms": 5.5, "mfc": "white", "mec": "black", "mew": 0.8}
SIDED: dict[str, Any] = {"ms": 4, "mfc": "0.45", "mec": "0.45"}
GAINS: dict[str, dict[str, Any]] = {
    "gain from $-1$ %": {"marker": "<", **SIDED},
    "from $+1$ %": {"marker": ">", **SIDED},
    "mean": {"marker": "o", "ms": 4.5, "mfc": "black", "mec": "black"},
}
BESIDE = 0.03  # of the width, between a mark and its text


def draw_margin(margin: Margin, path: Path) -> Path:
    """Draw a margin into a PNG, PDF or SVG file and return its path."""
    with style():
        return save_figure(make_margin_figure(margin), path)


def make_margin_figure(margin: Margin) -> Figure:
    """Return what the scans found along each direction, with the nearest changes, and the gains beside."""
    with style():
        handles = _handles([margin])
        if any(math.isfinite(gain.per_percent) and gain.enters for gain in margin.gains):
            handles += [Line2D([], [], label=text, ls="", **look) for text, look in GAINS.items()]
        rows = max(len(margin.lines), len(margin.gains))
        height = ROW * rows + FOOT + legend_height(handles, PAGE - 0.3)
        figure = Figure(figsize=(PAGE, height), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(2.6, 1.0))
        _draw_lines(left, margin)
        _draw_gains(right, margin)
        legend_outside(figure, handles, "upper")
        return figure


def make_margins_figure(margins: Sequence[Sequence[Margin]], rows: Sequence[str], columns: Sequence[str]) -> Figure:
    """Return what the scans of several margins found, a row for each craft and a column for each criterion."""
    with style():
        handles = _handles([margin for row in margins for margin in row])
        heights = [max(len(margin.lines) for margin in row) for row in margins]
        size = PAGE, ROW * sum(heights) + 0.6 * len(rows) + legend_height(handles, PAGE - 0.3)
        figure = Figure(figsize=size, layout="constrained")
        panels: list[list[Axes]] = figure.subplots(
            len(rows), len(columns), squeeze=False, height_ratios=heights
        ).tolist()
        for i, j in np.ndindex(len(rows), len(columns)):
            axes, margin = panels[i][j], margins[i][j]
            _draw_lines(axes, margin)
            axes.set_title(f"{rows[i]}, {columns[j]}")
            axes.label_outer()
        legend_outside(figure, handles, "upper")
        return figure


def _handles(margins: Sequence[Margin]) -> list[Artist]:
    """Return a legend's entries for what some margins found."""
    sides = [side for margin in margins for line in margin.lines for side in line.sides]
    present = {_kind(probe.answer) for side in sides for _, probe in side.scan}
    present |= {_kind(line.base.answer) for margin in margins for line in margin.lines}
    handles: list[Artist] = [patch(colour, meaning) for name, (colour, meaning) in FOUND.items() if name in present]
    if any(side.way.ended_by for side in sides):
        handles.append(patch("white", "no such craft in the model", edgecolor="0.6", hatch="//////"))
    handles.append(Line2D([], [], label="nearest change", ls="", **CHANGE))
    if any(side.bound for side in sides):
        handles.append(Line2D([], [], label="a bound of it", ls="", **BOUND))
    handles.append(Line2D([], [], label="the craft", color="black", lw=CRAFT))
    return handles


def _draw_lines(axes: Axes, margin: Margin) -> None:
    """Draw a band for each direction, coloured by what was found, over the relative distance in per cent."""
    for row, line in enumerate(margin.lines):
        scale = 100 / line.direction.scale
        _mark(axes, row, 0.0, line.base.answer, 0.5 * line.sides[0].way.spacing * scale)
        for side in line.sides:
            half = 0.5 * side.way.spacing * scale
            for distance, probe in side.scan:
                _mark(axes, row, side.way.sign * distance * scale, probe.answer, half)
            if side.way.ended_by:
                _draw_end(axes, row, side, side.way.limit * scale + half, 102 * margin.reach)
            if side.change is not None:
                look = BOUND if side.bound else CHANGE
                axes.add_line(Line2D([side.change * scale], [row], ls="", zorder=3, **look))
        axes.plot([0.0, 0.0], [row - 0.5 * BAND, row + 0.5 * BAND], color="black", lw=CRAFT, zorder=2)
    axes.set_yticks(range(len(margin.lines)), [_name(margin, line) for line in margin.lines])
    axes.set_ylim(len(margin.lines) - 0.4, -0.6)
    axes.set_xlim(-102 * margin.reach, 102 * margin.reach)
    axes.set_xlabel("change of the parameter (%)")
    axes.tick_params(axis="y", length=0)


def _kind(answer: Answer) -> str:
    """Return what a point is drawn as, an entry of FOUND: what decided, not what is most frequent."""
    if not answer.tumbles:
        return SAFE
    share = answer.numbers.get("share")
    return answer.what if share is None else next(name for name, end in SHARES.items() if share <= end)


def _mark(axes: Axes, row: int, x: float, answer: Answer, half: float) -> None:
    """Draw a point of a scan as a box as wide as the scan's spacing."""
    axes.barh(row, 2 * half, left=x - half, height=BAND, color=FOUND[_kind(answer)][0], lw=0.0)


def _draw_end(axes: Axes, row: int, side: Side, begin: float, end: float) -> None:
    """Hatch a row beyond the model's domain, from one per cent to another."""
    if end > begin:
        low = min(side.way.sign * begin, side.way.sign * end)
        axes.barh(row, end - begin, left=low, height=BAND, zorder=0, **NOWHERE)


def _name(margin: Margin, line: Line) -> str:
    along = symbol(margin.sweep.model, line.direction.along)
    return along if line.direction.name == line.direction.along else f"hovering, {along}"


def _draw_gains(axes: Axes, margin: Margin) -> None:
    """Draw the gain of each parameter, from both sides, and half their sum."""
    model, leading = margin.sweep.model, margin.leading.direction.name
    known = [abs(x) for gain in margin.gains for x in _values(gain) if math.isfinite(x)]
    largest = max(known, default=0.0) or 1.0
    axes.axvline(0.0, color="0.7", lw=0.6, zorder=0)
    for row, gain in enumerate(margin.gains):
        below, above, mean = _values(gain)
        if not gain.enters or not math.isfinite(mean):
            why = "only a bound" if gain.bound else "no change seen"
            text = why if gain.enters else "does not enter"
            axes.text(BESIDE * largest, row, text, va="center", fontsize=6, color="0.3")
            continue
        axes.plot([below, above], [row, row], color="0.6", lw=1.0, zorder=1)
        for value, look in zip((below, above, mean), GAINS.values(), strict=True):
            axes.add_line(Line2D([value], [row], ls="", zorder=2, **look))
    names = [symbol(model, gain.name) if gain.enters else f"${gain.name}$" for gain in margin.gains]
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(len(names), len(margin.lines)) - 0.4, -0.6)
    axes.set_xlim(-1.15 * largest, 1.15 * largest)
    if not known or not np.any(known):
        axes.set_xticks([0.0])
    quantity = model.quantity(margin.leading.direction.along)
    axes.set_xlabel(with_unit(f"gain in {symbol(model, leading)} per +1 %\n", quantity.unit).replace("\n ", "\n"))
    axes.tick_params(axis="y", length=0)


def _values(gain: Gain) -> tuple[float, float, float]:
    return gain.from_below, gain.from_above, gain.per_percent
