"""Maps over two axes: regions, and the largest exponent with a neutral zero."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from quavsweep.codes import REGION, Region
from quavsweep.grid import Axis
from quavsweep.models import Model
from quavsweep.plot.style import code_colours, label, rate_label

if TYPE_CHECKING:
    from quavsweep.result import Result

VOID = "#4d4d4d"  # a computed cell that has no such number


def draw_regions(axes: Axes, result: Result) -> None:
    """Draw the region of each cell, the first axis of the sweep to the right, the second upward."""
    colours, norm = code_colours(REGION)
    region = result["region"]
    _mesh(axes, result, region, cmap=colours, norm=norm)
    handles = region_handles(region)
    axes.legend(
        handles=handles,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=len(handles) if len(handles) <= 4 else 3,
        frameon=False,
        handlelength=1.2,
        handleheight=1.0,
        columnspacing=1.2,
        borderpad=0.2,
    )


def region_handles(region: np.ndarray) -> list[Patch]:
    """Return a legend's patches for the regions that are present, hatched for cells that are not computed."""
    handles = [
        Patch(facecolor=code.colour, edgecolor="black", linewidth=0.4, label=code.meaning)
        for code in REGION
        if code.number != Region.NONE and (region == code.number).any()
    ]
    if (region == Region.NONE).any():
        handles.append(Patch(facecolor="white", edgecolor="0.4", linewidth=0.4, hatch="////", label="not computed"))
    return handles


def draw_largest(figure: Figure, axes: Axes, result: Result) -> None:
    """Draw the largest exponent: blue below zero, white at zero, red above."""
    values = result["lyapunov"][..., 0]
    # Each side of zero has its own scale, since exponents of sinks and of chaos differ in size.
    low = _round_limit(-values) or _round_limit(values) or 1.0
    high = _round_limit(values) or low
    norm = TwoSlopeNorm(0.0, -low, high)
    mesh = _mesh(axes, result, values, cmap="RdBu_r", norm=norm)
    bar = figure.colorbar(mesh, ax=axes, extend="both", aspect=25, pad=0.02)
    bar.set_label(rate_label(result.sweep.model, r"\lambda_1"))
    bar.set_ticks([-low, -0.5 * low, 0.0, 0.5 * high, high])
    bar.ax.yaxis.set_major_formatter("{x:.3g}")
    bar.ax.minorticks_off()


def _round_limit(values: np.ndarray) -> float:
    """Return a round number that all but one in 200 of the positive values stay below; 0 if there are none."""
    positive = values[values > 0]
    if not positive.size:
        return 0.0
    top = float(np.percentile(positive, 99.5))
    unit = 10.0 ** np.floor(np.log10(top))
    return float(unit * np.ceil(top / unit * 5 - 1e-9) / 5)


def _mesh(axes: Axes, result: Result, values: np.ndarray, **colours: Any) -> QuadMesh:
    """Draw one value per cell; cells that are not computed are hatched."""
    across, up = result.sweep.grid.axes
    x, y = np.asarray(across.values), np.asarray(up.values)
    order = np.ix_(np.argsort(x), np.argsort(y))
    values, todo = values[order].T, (result["region"] == Region.NONE)[order].T
    x, y = edges(np.sort(x)), edges(np.sort(y))
    axes.set_facecolor("white")
    if todo.any():
        axes.patch.set(hatch="////", edgecolor="0.6")
    void = ~todo & ~np.isfinite(values)
    if void.any():
        axes.pcolormesh(x, y, np.ma.masked_where(~void, void), cmap=ListedColormap([VOID]), rasterized=True)
    mesh = axes.pcolormesh(x, y, np.ma.masked_where(todo | void, values), rasterized=True, **colours)
    set_scale(axes.xaxis, result.sweep.model, across)
    set_scale(axes.yaxis, result.sweep.model, up)
    return mesh


def set_scale(axis: XAxis | YAxis, model: Model, quantity: Axis) -> None:
    """Scale and label an axis of a figure as an axis of a sweep.

    A common power of ten goes into the label, because matplotlib's own place for it is where the legend is.
    """
    values = np.asarray(quantity.values)
    power = 0
    if axis_is_log(values):
        (axis.axes.set_xscale if isinstance(axis, XAxis) else axis.axes.set_yscale)("log")
    else:
        largest = float(np.abs(values).max())
        if largest and not 0.01 <= largest < 1e5:
            power = int(np.floor(np.log10(largest)))
            axis.set_major_formatter(lambda value, position: f"{value / 10.0**power:.6g}")
    axis.set_label_text(label(model, quantity.name, power))


def edges(values: np.ndarray) -> np.ndarray:
    """Return the borders of cells around ascending values, (n + 1,): midway, and as far beyond the ends.

    Midway in the logarithm where the values are spaced so.
    """
    if axis_is_log(values):
        return np.asarray(np.exp(edges(np.log(values))))
    if len(values) == 1:
        width = abs(values[0]) * 0.5 or 0.5
        return np.array([values[0] - width, values[0] + width])
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def axis_is_log(values: np.ndarray) -> bool:
    """Whether values are spaced evenly in their logarithm and not in themselves."""
    if len(values) < 3 or (values <= 0).any():
        return False
    return bool(np.allclose(np.diff(np.log(values)), np.log(values[1] / values[0]), rtol=1e-6)) and not bool(
        np.allclose(np.diff(values), values[1] - values[0], rtol=1e-6)
    )
