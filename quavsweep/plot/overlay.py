"""Curves over maps, and marks along a single axis, from equations and from files."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.path import Path as Polyline
from matplotlib.transforms import Bbox

from quavsweep.config import Sweep
from quavsweep.errors import ConfigError
from quavsweep.grid import Axis
from quavsweep.plot.along import drawn_axes, quantities_at
from quavsweep.plot.contour import roots, zero_lines
from quavsweep.plot.curve_file import read_curve
from quavsweep.plot.equation import parse_equation
from quavsweep.plot.scale import drawn_range, is_log
from quavsweep.plot.style import DASHES, plain, wrapped

LABELLED = re.compile(r"\s*([^:=]*[^:=\s])\s*:\s*(\S.*)", re.DOTALL)
MESH = 601  # points of the fine mesh along each axis
LINE_MESH = 20001  # and along a single one
WIDE = 56  # characters of a label in a legend


@dataclass(frozen=True)
class Curve:
    """Polylines (n, 2) over a map, or positions (n,) along an axis, with a label and a pattern of dashes."""

    label: str
    pieces: tuple[np.ndarray, ...]
    dashes: Any = "-"

    @property
    def handle(self) -> Line2D:
        """The line in a legend."""
        return Line2D([], [], color="black", lw=1.0, ls=self.dashes, label=wrapped(plain(self.label), WIDE))


def make_curves(texts: Sequence[str], sweeps: Sequence[Sweep]) -> list[list[Curve]]:
    """Return for each sweep the curves of some texts, `[label:] equation or path`, each with its own dashes.

    Raises
    ------
    ConfigError
        If a text is neither, a sweep has no axes, or a curve crosses no map.
    """
    found = [[_make_curve(text, i, sweep) for i, text in enumerate(texts)] for sweep in sweeps]
    for text, curves in zip(texts, zip(*found, strict=True), strict=True):
        if not any(len(piece) for curve in curves for piece in curve.pieces):
            raise _missed(text, sweeps[0])
    return found


def draw_curves(axes: Axes, curves: Sequence[Curve]) -> None:
    """Draw curves in black on a white ground, to be seen on any colour."""
    for curve in curves:
        for piece in curve.pieces:
            axes.plot(*piece.T, color="white", lw=2.4, zorder=3)
            axes.plot(*piece.T, color="black", lw=1.0, ls=curve.dashes, zorder=4)


def draw_marks(axes: Axes, curves: Sequence[Curve]) -> None:
    """Draw vertical lines at the positions of curves along a single axis."""
    for curve in curves:
        for position in np.concatenate(curve.pieces):
            axes.axvline(position, color="black", lw=1.0, ls=curve.dashes, zorder=1)


def _make_curve(text: str, index: int, sweep: Sweep) -> Curve:
    """Return a curve, without pieces if it lies elsewhere."""
    label, source, is_file = _read(text)
    count = len(sweep.grid.axes)
    if count == 0 or (count == 1 and is_file):
        what, axes = ("a curve from a file", "one axis") if count else ("a curve", "no axes")
        raise ConfigError(f"{what} needs a map", text, f"this sweep has {axes}")
    if count == 1:
        pieces = _marks(source, sweep)
    else:
        pieces = _file_lines(Path(source), sweep) if is_file else _equation_lines(source, sweep)
    return Curve(label, tuple(pieces), DASHES[index % len(DASHES)])


def _missed(text: str, sweep: Sweep) -> ConfigError:
    """Return the error of a curve that is nowhere to be seen."""
    ranges = [f"{axis.name} is {min(axis.values):g} to {max(axis.values):g}" for axis in drawn_axes(sweep)]
    return ConfigError(f"does not cross the {'map' if len(ranges) == 2 else 'axis'}", text, ", ".join(ranges))


def _read(text: str) -> tuple[str, str, bool]:
    """Return label and source of an overlay, and whether the source is a file."""
    match = None if os.path.isfile(text) else LABELLED.fullmatch(text)
    label, source = match.groups() if match else ("", text)
    is_file = os.path.isfile(source)
    if not is_file and "=" not in source:
        raise ConfigError("is neither a file nor an equation", text, "write left = right, or the path of a CSV file")
    return label or (Path(source).stem if is_file else source.strip()), source, is_file


def _marks(source: str, sweep: Sweep) -> list[np.ndarray]:
    """Return where an equation holds along the only axis."""
    (axis,) = drawn_axes(sweep)
    difference = _difference(source, sweep)
    mesh = np.linspace(*_straight_range(axis), LINE_MESH)
    return [_bent(axis, roots(mesh, lambda x: difference(_bent(axis, x))))]


def _equation_lines(source: str, sweep: Sweep) -> list[np.ndarray]:
    """Return the lines on which an equation holds."""
    across, up = drawn_axes(sweep)
    difference = _difference(source, sweep)

    def at(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return difference(_bent(across, x), _bent(up, y))

    x, y = (np.linspace(*_straight_range(axis), MESH) for axis in (across, up))
    lines = zero_lines(x, y, at(x[:, None], y[None, :]), at)
    return [np.column_stack([_bent(across, line[:, 0]), _bent(up, line[:, 1])]) for line in lines]


def _difference(source: str, sweep: Sweep) -> Callable[..., np.ndarray]:
    """Return left - right of an equation as a function of the axes' values, in their order."""
    axes = drawn_axes(sweep)
    equation = parse_equation(source, list(dict.fromkeys([*sweep.grid.quantities, *sweep.parameters])))

    def difference(*values: np.ndarray) -> np.ndarray:
        varied = {n: x for axis, at in zip(axes, values, strict=True) for n, x in quantities_at(axis, at).items()}
        found = equation.difference({**sweep.parameters, **varied})
        return np.broadcast_to(found, np.broadcast_shapes(*(np.shape(value) for value in values)))

    return difference


def _file_lines(path: Path, sweep: Sweep) -> list[np.ndarray]:
    """Return the curve of a file, or none if it lies outside the map."""
    across, up = drawn_axes(sweep)
    points = read_curve(path, across.name, up.name)
    for axis, values in zip((across, up), points.T, strict=True):
        if is_log(axis) and (values <= 0).any():
            raise ConfigError(f"{axis.name} is not above 0 everywhere", str(path), "its axis is logarithmic")
    straight = np.column_stack([_straight(across, points[:, 0]), _straight(up, points[:, 1])])
    (left, right), (bottom, top) = _straight_range(across), _straight_range(up)
    seen = Polyline(straight).intersects_bbox(Bbox([[left, bottom], [right, top]]), filled=False)
    return [points] if seen else []


def _straight(axis: Axis, values: Any) -> Any:
    """Return values as a figure's axis spaces them."""
    return np.log(values) if is_log(axis) else values


def _straight_range(axis: Axis) -> tuple[float, float]:
    """Return where the cells begin and end along a figure's axis."""
    low, high = drawn_range(axis)
    return float(_straight(axis, low)), float(_straight(axis, high))


def _bent(axis: Axis, values: Any) -> Any:
    """Return the values of positions along a figure's axis."""
    return np.exp(values) if is_log(axis) else values
