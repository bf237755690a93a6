"""Two ways to tell what orbits do over one plane, side by side, and where they agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.codes import Code
from quavsweep.plot.code import code_colours, code_handles
from quavsweep.plot.legend import legend_above
from quavsweep.plot.scale import drawn_range, edges, set_scale
from quavsweep.plot.style import PAGE, set_room

if TYPE_CHECKING:
    from quavsweep.result import Result

HEIGHT = 2.75  # inches
WIDTH = 2.0  # inches of a legend above a panel
AGREEMENT = (
    Code(0, "differ", "differ", "#d55e00"),
    Code(1, "agree", "agree", "#d9d9d9"),
    Code(2, "open", "undecided", "#56b4e9"),
)


@dataclass(frozen=True)
class Told:
    """What one way tells: a code for each cell.

    Parameters
    ----------
    title : str
    codes : tuple of Code
    values : (n, m) int
        Over the axes of the sweep.
    """

    title: str
    codes: tuple[Code, ...]
    values: np.ndarray


def make_agreement_figure(result: Result, maps: Sequence[Told]) -> Figure:
    """Return maps of codes over the two axes of a sweep, beside each other, each with its legend.

    Parameters
    ----------
    result : Result
        Of the sweep over the plane.
    maps : sequence of Told
    """
    figure = Figure(figsize=(PAGE, HEIGHT), layout="constrained")
    set_room(figure, 0.04)
    grid = figure.subplots(1, len(maps), sharey=True)
    for axes, told in zip(grid, maps, strict=True):
        _draw(axes, result, told)
        axes.label_outer()
    return figure


def _draw(axes: Axes, result: Result, told: Told) -> None:
    across, up = result.sweep.grid.axes
    colours, norm = code_colours(told.codes)
    borders = edges(np.asarray(across.values)), edges(np.asarray(up.values))
    axes.pcolormesh(*borders, told.values.T, cmap=colours, norm=norm, rasterized=True)
    set_scale(axes.xaxis, result.sweep.model, across)
    set_scale(axes.yaxis, result.sweep.model, up)
    axes.set(xlim=drawn_range(across), ylim=drawn_range(up))
    none = np.zeros(told.values.shape, dtype=bool)
    legend_above(axes, code_handles(told.values, told.codes, none), WIDTH, title=told.title)
