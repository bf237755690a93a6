"""How the exponents of a single cell settle while they are averaged."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from quavsweep.codes import Region
from quavsweep.plot.scale import set_values
from quavsweep.plot.style import line_colours, measured, number, rate_unit, with_unit

if TYPE_CHECKING:
    from quavsweep.point import Point

SETTLING = 0.2  # share of the averages, from the first, that may lie outside the panel


def draw_convergence(axes: Axes, point: Point) -> None:
    """Draw averages of the exponents until each time, with their standard errors, and the exact ones of a sink."""
    model, count = point.sweep.model, point.exponents.shape[1]
    exact = exact_exponents(point)
    for k, colour in enumerate(line_colours(count)):
        values = point.exponents[:, k]
        error = np.where(np.isfinite(point.errors[:, k]), point.errors[:, k], 0.0)
        axes.plot(point.averaged_until, values, color=colour, lw=0.8, marker="." if len(values) == 1 else "")
        axes.fill_between(point.averaged_until, values - error, values + error, color=colour, alpha=0.25, linewidth=0)
        if exact is not None:
            axes.axhline(exact[k], color=colour, lw=0.8, ls="--")
    axes.axhline(0.0, color="0.3", lw=0.5, ls=":", zorder=0.5)
    late = point.exponents[int(SETTLING * len(point.exponents)) :]
    seen = np.concatenate([late.ravel(), [0.0], [] if exact is None else exact])
    _set_range(axes, seen)
    set_values(axes.yaxis, seen, r"$\lambda_k$", rate_unit(model))
    axes.set_xlabel(with_unit("averaged until $t$", model.time_unit))
    axes.margins(x=0.0)


def exact_exponents(point: Point) -> np.ndarray | None:
    """Return the exponents of a certified sink, None where there is no certificate."""
    sink = int(point.values["region"]) == Region.SINK
    return np.asarray(point.values["lyapunov"]) if sink and "lyapunov" in point.values else None


def convergence_handles(point: Point) -> list[Artist]:
    """Return a legend's lines with the final values of the exponents."""
    exact, count = exact_exponents(point), point.exponents.shape[1]
    handles: list[Artist] = []
    for k, colour in enumerate(line_colours(count)):
        name = rf"\lambda_{{{k + 1}}} = "
        if exact is not None:
            text = f"${name}{number(exact[k])}$"
        elif len(point.exponents):
            text = f"${name}{measured(point.exponents[-1, k], point.errors[-1, k])}$"
        else:
            text = f"${name}$ not averaged"
        handles.append(Line2D([], [], color=colour, label=text))
    if exact is not None and count:
        handles.append(Line2D([], [], color="0.3", ls="--", label="exact"))
    return handles


def _set_range(axes: Axes, values: np.ndarray) -> None:
    """Show these values with some room around them."""
    values = values[np.isfinite(values)]
    margin = 0.12 * np.ptp(values) or 1.0
    axes.set_ylim(values.min() - margin, values.max() + margin)
