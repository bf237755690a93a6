"""A contact sheet: many figures small on one page, in rows of equal width."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.image import imread

WIDTH = 7.0  # inches
ROW = 1.5  # inches that a row is high, about
GAP = 0.12  # inches between pictures
NAME = 0.22  # inches for the name below one


def make_contact_sheet(pictures: Sequence[tuple[str, Path]]) -> Figure:
    """Return a sheet of pictures with their names.

    Parameters
    ----------
    pictures : sequence of (str, Path)
        Name and PNG file of each, in order; at least one.
    """
    images = [(name, imread(path)) for name, path in pictures]
    rows = _rows([image.shape[1] / image.shape[0] for _, image in images])
    heights = [(WIDTH - GAP * (len(row) + 1)) / sum(aspect for _, aspect in row) for row in rows]
    heights = [min(height, 1.5 * ROW) for height in heights]  # a last row may be short
    total = sum(heights) + (GAP + NAME) * len(rows) + GAP
    figure = Figure(figsize=(WIDTH, total))
    top = total - GAP
    for row, height in zip(rows, heights, strict=True):
        left = GAP
        for i, aspect in row:
            name, image = images[i]
            width = height * aspect
            box = (left / WIDTH, (top - height) / total, width / WIDTH, height / total)
            axes = figure.add_axes(box)
            axes.imshow(np.asarray(image), aspect="auto", interpolation="antialiased")
            axes.set_axis_off()
            figure.text((left + width / 2) / WIDTH, (top - height - 0.04) / total, name, ha="center", va="top")
            left += width + GAP
        top -= height + NAME + GAP
    return figure


def _rows(aspects: Sequence[float]) -> list[list[tuple[int, float]]]:
    """Return pictures, as number and ratio of width to height, in rows that are about as high as wanted."""
    rows: list[list[tuple[int, float]]] = [[]]
    for i, aspect in enumerate(aspects):
        if rows[-1] and (sum(a for _, a in rows[-1]) + aspect / 2) * ROW > WIDTH:
            rows.append([])
        rows[-1].append((i, aspect))
    return rows
