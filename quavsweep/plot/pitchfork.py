"""A pitchfork bifurcation: the branches of equilibria along one parameter, and its curve in the plane of two."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from quavsweep.models import Model
from quavsweep.plot.legend import legend_above
from quavsweep.plot.style import LINES, PAGE, PANEL, SMALL, label, number, symbol

WIDTH = 3.0  # inches of a legend
SIDES = ("#f0f0f0", "#cfe3f1")  # of the regions on both sides of a curve


@dataclass(frozen=True)
class BranchLine:
    """A branch of equilibria.

    Parameters
    ----------
    name : str
        As `E_1`, LaTeX without dollars.
    parameter, value : (n,) float64
        Parameter, ascending, and the state that is drawn.
    stable : (n,) bool
    """

    name: str
    parameter: np.ndarray
    value: np.ndarray
    stable: np.ndarray


@dataclass(frozen=True)
class Region:
    """A name in the plane, and where it stands."""

    text: str
    place: tuple[float, float]


@dataclass(frozen=True)
class PitchforkData:
    """What the two panels show.

    Parameters
    ----------
    model : Model
    state, across, up : str
        The state of the branches, their parameter, and the other parameter of the plane.
    branches : sequence of BranchLine
    curve : (n, 2) float64
        The pitchfork in the plane.
    window : (float, float, float, float)
        Of the plane: left, right, bottom, top.
    place : (float, float)
        The bifurcation of the branches in the plane.
    regions : sequence of Region
        Below and above the curve.
    """

    model: Model
    state: str
    across: str
    up: str
    branches: Sequence[BranchLine]
    curve: np.ndarray
    window: tuple[float, float, float, float]
    place: tuple[float, float]
    regions: Sequence[Region]


def make_pitchfork_figure(data: PitchforkData) -> Figure:
    """Return a figure of two panels: branches, stable solid and unstable dashed, and the curve in the plane."""
    figure = Figure(figsize=(PAGE, PANEL[1]), layout="constrained")
    left, right = figure.subplots(1, 2)
    _draw_branches(left, data)
    _draw_plane(right, data)
    for axes, letter in ((left, "a"), (right, "b")):
        axes.set_title(f"({letter})", loc="left", fontweight="bold")
    return figure


def _draw_branches(axes: Axes, data: PitchforkData) -> None:
    """Draw the branches with their names at their ends."""
    for branch, colour in zip(data.branches, LINES, strict=False):
        for stable, dashes in ((True, "-"), (False, "--")):
            shown = np.where(branch.stable == stable, branch.value, np.nan)
            axes.plot(branch.parameter, shown, color=colour, ls=dashes, lw=1.2)
        end = branch.parameter[-1], branch.value[-1]
        axes.annotate(f"${branch.name}$", end, (-14, 6), textcoords="offset points", color=colour, fontsize=8)
    axes.plot(data.place[0], _at(data.branches[0], data.place[0]), "o", color="black", ms=4, zorder=5)
    quantity = data.model.quantity(data.across)
    text = f"{symbol(data.model, data.across)} = {data.place[0]:.6g} {quantity.unit}"
    axes.annotate(text, (data.place[0], 0.0), (42, 14), textcoords="offset points", fontsize=SMALL)
    axes.set(xlabel=label(data.model, data.across), ylabel=label(data.model, data.state))
    axes.margins(y=0.12)
    axes.set_xlim(0.0, max(float(branch.parameter[-1]) for branch in data.branches))
    handles = [
        Line2D([], [], color="0.3", lw=1.2, ls=dashes, label=name)
        for dashes, name in (("-", "stable"), ("--", "unstable"))
    ]
    legend_above(axes, handles, WIDTH)


def _at(branch: BranchLine, value: float) -> float:
    return float(np.interp(value, branch.parameter, branch.value))


def _draw_plane(axes: Axes, data: PitchforkData) -> None:
    """Draw the curve between its two regions, and the line along which the branches are drawn."""
    left, right, bottom, top = data.window
    curve = data.curve[np.argsort(data.curve[:, 1])]
    axes.fill_betweenx(curve[:, 1], left, curve[:, 0], color=SIDES[0], linewidth=0)
    axes.fill_betweenx(curve[:, 1], curve[:, 0], right, color=SIDES[1], linewidth=0)
    axes.plot(curve[:, 0], curve[:, 1], color="black", lw=1.2)
    axes.axhline(data.place[1], color="0.3", lw=0.6, ls=":")
    axes.plot(*data.place, "o", color="black", ms=4, zorder=5)
    quantity = data.model.quantity(data.up)
    text = rf"{symbol(data.model, data.up)} = ${number(data.place[1])}$ {quantity.unit}"
    axes.annotate(text, (right, data.place[1]), (-4, 3), textcoords="offset points", ha="right", fontsize=SMALL)
    for region in data.regions:
        axes.text(*region.place, region.text, ha="center", va="center", fontsize=8)
    axes.set(xlabel=label(data.model, data.across), ylabel=label(data.model, data.up))
    axes.set(xlim=(left, right), ylim=(bottom, top))
    handles = [
        Line2D([], [], color="black", lw=1.2, label="pitchfork"),
        Line2D([], [], color="0.3", lw=0.6, ls=":", label="panel (a)"),
    ]
    legend_above(axes, handles, WIDTH)
