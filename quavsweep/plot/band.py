"""The regions along a single axis, as a band on top of a panel, and hatching where nothing is computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from quavsweep.codes import REGION, Region
from quavsweep.plot.along import drawn_axes
from quavsweep.plot.code import code_colours, code_handles
from quavsweep.plot.scale import edges

if TYPE_CHECKING:
    from quavsweep.result import Result

HEIGHT = 0.08  # inches
MANY = 100  # cells


def draw_band(axes: Axes, result: Result, panel_height: float) -> float:
    """Draw the band on top of a panel of a height in inches, and return its end in heights of the panel."""
    (axis,) = drawn_axes(result.sweep)
    region = result["region"][np.argsort(axis.values)]
    colours, norm = code_colours(REGION)
    height = HEIGHT / panel_height
    strip = axes.inset_axes((0.0, 1.0, 1.0, height), sharex=axes)
    shown = np.ma.masked_equal(region, Region.NONE)[None, :]
    strip.pcolormesh(edges(np.sort(axis.values)), [0.0, 1.0], shown, cmap=colours, norm=norm, rasterized=True)
    strip.set_axis_off()
    return 1.0 + height


def band_handles(result: Result) -> list[Artist]:
    """Return a legend's patches for the regions that are present."""
    region = result["region"]
    return code_handles(region, REGION, region == Region.NONE)


def hatch(axes: Axes, result: Result, todo: np.ndarray) -> None:
    """Hatch the cells along an axis that are not computed; where there are many, neighbours together."""
    (axis,) = drawn_axes(result.sweep)
    borders = edges(np.sort(axis.values))
    cells = np.flatnonzero(todo[np.argsort(axis.values)])
    apart = np.diff(cells) > (1 if len(cells) > MANY else 0)
    for run in np.split(cells, np.flatnonzero(apart) + 1) if len(cells) else ():
        left, right = borders[run[0]], borders[run[-1] + 1]
        axes.axvspan(left, right, facecolor="none", edgecolor="0.6", hatch="////", linewidth=0)
