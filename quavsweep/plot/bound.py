"""Energy bounds in space: an attractor, the ellipsoid of zero power that it crosses, and one that holds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from quavsweep.analysis.quadrotor.bound import Ellipsoid
from quavsweep.analysis.quadrotor.casimir import Extremes
from quavsweep.models import Model
from quavsweep.plot.legend import LOOK
from quavsweep.plot.space import label_box
from quavsweep.plot.style import LINES, PAGE
from quavsweep.plot.trace import LATE

HEIGHT = 2.9  # inches
LEFT, BOTTOM, APART, WIDE, HIGH = 0.01, 0.1, 0.327, 0.27, 0.72  # of the figure; layouts know nothing of boxes
ZERO, BOUND = "#009e73", "#e69f00"  # of the two ellipsoids
VIEW = {"elev": 18.0, "azim": -50.0}
MARKS: dict[str, dict[str, Any]] = {
    "maxima": {"marker": "o", "ms": 2.6, "mfc": "none", "mec": LINES[2], "mew": 0.7, "label": "maxima of energy"},
    "minima": {"marker": "x", "ms": 2.8, "mec": LINES[4], "mew": 0.8, "label": "minima of energy"},
    "saddle": {"marker": "^", "ms": 5.0, "mfc": "white", "mec": "black", "mew": 0.8, "label": "saddle"},
    "sinks": {"marker": "D", "ms": 4.0, "mfc": "#f0e442", "mec": "black", "mew": 0.8, "label": "sinks"},
}


@dataclass(frozen=True)
class Scene:
    """What the figure shows.

    Parameters
    ----------
    model : Model
    orbit : (n, 3) float64
        On the attractor [rad/s].
    extremes : Extremes
        Of the energy along it.
    saddle, sinks : (m, 3) float64
        Equilibria [rad/s].
    zero_power, supremum : Ellipsoid
    """

    model: Model
    orbit: np.ndarray
    extremes: Extremes
    saddle: np.ndarray
    sinks: np.ndarray
    zero_power: Ellipsoid
    supremum: Ellipsoid


def make_bound_figure(scene: Scene) -> Figure:
    """Return three panels: crossings with the ellipsoid of zero power, the same without it, and the bound."""
    figure = Figure(figsize=(PAGE, HEIGHT))
    points = {
        "maxima": scene.extremes.maxima,
        "minima": scene.extremes.minima,
        "saddle": scene.saddle,
        "sinks": scene.sinks,
    }
    surfaces = ((scene.zero_power, ZERO), None, (scene.supremum, BOUND))
    for i, (letter, surface) in enumerate(zip("abc", surfaces, strict=True)):
        place = (LEFT + APART * i, BOTTOM, WIDE, HIGH)
        axes: Any = figure.add_axes(place, projection="3d", computed_zorder=False)
        axes.plot(*scene.orbit.T, color=LATE, lw=0.3, rasterized=True, zorder=1)
        shown = points if i < 2 else {name: points[name] for name in ("saddle", "sinks")}
        for name, where in shown.items():
            axes.plot(*where.T, ls="", zorder=3, **MARKS[name])
        extent = [scene.orbit, *shown.values()]
        if surface is not None:
            ellipsoid, colour = surface
            extent.append(_draw_surface(axes, ellipsoid, colour))
        label_box(axes, scene.model, np.concatenate(extent), 3)
        axes.view_init(**VIEW)
        figure.text(LEFT + APART * i, BOTTOM + HIGH, f"({letter})", va="top")
    figure.legend(handles=_handles(), ncols=4, loc="upper center", **LOOK)
    return figure


def _draw_surface(axes: Any, ellipsoid: Ellipsoid, colour: str) -> np.ndarray:
    """Draw an ellipsoid, so that what is within is seen, and return its points, (n, 3)."""
    points = ellipsoid.surface(25, 37)
    look = {"color": colour, "edgecolor": colour, "lw": 0.15, "shade": False, "rasterized": True}
    axes.plot_surface(*np.moveaxis(points, -1, 0), alpha=0.13, zorder=2, rstride=1, cstride=1, **look)
    return points.reshape(-1, 3)


def _handles() -> list[Artist]:
    return [
        Line2D([], [], color=LATE, lw=1.2, label="chaotic orbit"),
        Patch(facecolor=ZERO, alpha=0.4, label="zero power, (24)"),
        Patch(facecolor=BOUND, alpha=0.4, label="supremum, (25)"),
        *(Line2D([], [], ls="", **mark) for mark in MARKS.values()),
    ]
