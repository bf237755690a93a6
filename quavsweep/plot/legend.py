"""Legends that stand outside the data, in as many columns as fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.plot.style import SMALL, text_length

CHARACTER = 0.6 * SMALL / 72  # inches, about
HANDLE = 0.32  # inches of a box, a line, and the space between columns
ROW = 0.16  # inches
LOOK: dict[str, Any] = {
    "frameon": False,
    "handlelength": 1.4,
    "handleheight": 1.0,
    "handletextpad": 0.5,
    "columnspacing": 1.2,
    "borderpad": 0.2,
    "labelspacing": 0.3,
}


def legend_above(axes: Axes, handles: Sequence[Artist], width: float, base: float = 1.0, title: str = "") -> None:
    """Put a legend of a width in inches above axes; `base` is where it begins, in heights of the axes."""
    if handles:
        place = {"loc": "lower center", "bbox_to_anchor": (0.5, base), "borderaxespad": 0.2}
        axes.legend(handles=handles, ncols=_columns(handles, width), title=title or None, **place, **LOOK)


def legend_outside(figure: Figure, handles: Sequence[Artist], where: str) -> None:
    """Put a legend above or below all axes of a figure."""
    if handles:
        columns = _columns(handles, figure.get_figwidth() - 0.3)
        figure.legend(handles=handles, ncols=columns, loc=f"outside {where} center", **LOOK)


def legend_height(handles: Sequence[Artist], width: float) -> float:
    """Return the height in inches of a legend that may be so wide, about."""
    if not handles:
        return 0.0
    lines = max(str(handle.get_label()).count("\n") + 1 for handle in handles)
    return ROW * lines * float(np.ceil(len(handles) / _columns(handles, width))) + 0.06


def _columns(handles: Sequence[Artist], width: float) -> int:
    """Return the largest number of columns that fit into a width."""
    widths = np.array([_width(str(handle.get_label())) for handle in handles])
    for columns in range(len(handles), 1, -1):
        if sum(column.max() for column in np.array_split(widths, columns)) <= width:
            return columns
    return 1


def _width(text: str) -> float:
    """Return the width of a legend's entry in inches, about."""
    return max(map(text_length, text.split("\n"))) * CHARACTER + HANDLE
