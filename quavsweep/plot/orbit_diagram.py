"""Orbit diagrams: all samples of a cell above its place on the axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from quavsweep.codes import Region
from quavsweep.config import Sweep
from quavsweep.plot.along import drawn_axes
from quavsweep.plot.observed import observed
from quavsweep.plot.quantity import Quantity
from quavsweep.plot.style import symbol

if TYPE_CHECKING:
    from quavsweep.result import Result

WIDTH = 130.0  # points; dots of neighbouring cells do not touch
SIZES = 0.5, 1.4  # points of a dot


def sampled_state(sweep: Sweep) -> str:
    """Return the state whose samples say most: that of the maxima, or the first that the section does not fix."""
    asked, names = sweep.measures.samples, sweep.model.state_names
    if asked is not None and asked.maxima is not None:
        return asked.maxima
    if asked is not None and asked.section is not None:
        return next((name for name in names if name != asked.section.of), names[0])
    return names[0]


def samples_text(result: Result, quantity: Quantity) -> str:
    """Return what the samples of a state are."""
    model, asked = result.sweep.model, result.sweep.measures.samples
    state = symbol(model, quantity.name.partition(".")[2])
    if asked is None:
        return quantity.text
    if asked.section is not None:
        return rf"{state} where ${symbol(model, asked.section.of)[1:-1]} = {asked.section.at:g}$"
    if asked.maxima is not None:
        where = symbol(model, asked.maxima)
        return f"maxima of {state}" if where == state else f"{state} at the maxima of {where}"
    return f"samples of {state}"


def draw_samples(axes: Axes, result: Result, quantity: Quantity) -> np.ndarray:
    """Draw all samples as dots, and the equilibrium of cells that ended in a sink; return all values drawn.

    The samples of such a cell are of the way there, which is not where its orbit ends.
    """
    (axis,) = drawn_axes(result.sweep)
    samples = np.where((result["region"] == Region.SINK)[:, None], np.nan, quantity.shown)
    x = np.broadcast_to(np.asarray(axis.values)[:, None], samples.shape)
    ends = _equilibria(result, quantity)
    kept = np.isfinite(samples)
    across, up = (np.concatenate(pair) for pair in ((x[kept], np.asarray(axis.values)), (samples[kept], ends)))
    size = float(np.clip(WIDTH / len(axis), *SIZES))
    axes.plot(across, up, ls="", marker="o", ms=size, mew=0, color="black", rasterized=True)
    axes.margins(y=0.06)
    return up


def _equilibria(result: Result, quantity: Quantity) -> np.ndarray:
    """Return the value at the equilibrium in which each cell ended, NaN elsewhere or where no samples are drawn."""
    variable, _, state = quantity.name.partition(".")
    sink = result["region"] == Region.SINK
    if variable != "samples" or "equilibrium" not in result:
        return np.full(sink.shape, np.nan)
    model = result.sweep.model
    if state in model.observable_names:
        return np.where(sink, observed(result, "equilibrium", state), np.nan)
    return np.where(sink, result["equilibrium"][:, model.state_names.index(state)], np.nan)
