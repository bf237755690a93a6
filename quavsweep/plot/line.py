"""Exponents along one axis, over a band that shows the regions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from quavsweep.codes import REGION, Region
from quavsweep.plot.region_map import edges, region_handles, set_scale
from quavsweep.plot.style import code_colours, rate_label

if TYPE_CHECKING:
    from quavsweep.result import Result

BAND = 0.06  # height of the band of regions, as a share of the axes


def draw_line(axes: Axes, result: Result) -> None:
    """Draw the exponents against the sweep's only axis, and its regions as a band below the top."""
    (axis,) = result.sweep.grid.axes
    order = np.argsort(axis.values)
    x = np.asarray(axis.values)[order]
    region = result["region"][order]
    handles: list[Artist] = []
    if "lyapunov" in result:
        for k in range(result["lyapunov"].shape[1]):
            (line,) = axes.plot(x, result["lyapunov"][order, k], lw=0.8, color=("black", "0.45", "0.7")[k % 3])
            line.set_label(rf"$\lambda_{k + 1}$")
            handles.append(line)
        axes.axhline(0.0, color="0.3", lw=0.5, ls=":")
        axes.set_ylabel(rate_label(result.sweep.model, r"\lambda_k"))
    axes.margins(y=0.12)
    colours, norm = code_colours(REGION)
    band = np.ma.masked_equal(region, Region.NONE)[None, :]
    strip = axes.inset_axes((0.0, 1.0, 1.0, BAND), sharex=axes)
    strip.pcolormesh(edges(x), [0.0, 1.0], band, cmap=colours, norm=norm, rasterized=True)
    strip.set_axis_off()
    borders = edges(x)
    for i in np.flatnonzero(region == Region.NONE):
        axes.axvspan(borders[i], borders[i + 1], facecolor="none", edgecolor="0.6", hatch="////", linewidth=0)
    handles += region_handles(region)
    axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0 + BAND), ncols=4, frameon=False)
    axes.set_xlim(borders[0], borders[-1])
    set_scale(axes.xaxis, result.sweep.model, axis)
