"""Strips: regions along a line, one row for each of several statements about it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from quavsweep.codes import REGION, Region
from quavsweep.plot.code import code_colours, code_handles
from quavsweep.plot.scale import edges

HEIGHT = 0.16  # inches of a row
Strips = Mapping[str, np.ndarray]  # from what a row is to regions, (n,) int8


def draw_strips(axes: Axes, positions: np.ndarray, strips: Strips) -> None:
    """Draw regions at ascending positions, the first row on top; nothing where there is none."""
    colours, norm = code_colours(REGION)
    regions = np.stack(list(strips.values()))
    borders = np.arange(len(regions) + 1) - 0.5
    shown = np.ma.masked_equal(regions, Region.NONE)
    axes.pcolormesh(edges(positions), borders, shown, cmap=colours, norm=norm, rasterized=True)
    axes.set_yticks(range(len(regions)), list(strips))
    axes.set_ylim(borders[-1], borders[0])
    axes.hlines(borders[1:-1], *edges(positions)[[0, -1]], color="white", lw=1.5)
    axes.tick_params(axis="y", length=0)


def strip_handles(strips: Strips) -> list[Artist]:
    """Return a legend's patches for the regions that are present."""
    regions = np.concatenate([region[region != Region.NONE] for region in strips.values()])
    return code_handles(regions, REGION, np.zeros(regions.shape, dtype=bool))
