"""Drawing a result into a file: which figure suits it, and in which format."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from quavsweep.errors import ConfigError, DiskError
from quavsweep.plot.line import draw_line
from quavsweep.plot.region_map import draw_largest, draw_regions
from quavsweep.plot.style import PANEL, style

if TYPE_CHECKING:
    from quavsweep.result import Result

FORMATS = (".png", ".pdf", ".svg")


def make_figure(result: Result) -> Figure:
    """Return the figure that suits a result.

    Two axes: maps of region and largest exponent. One axis: exponents along it, over a band of regions.

    Raises
    ------
    ConfigError
        If the sweep has no axis, or more than two.
    """
    count = len(result.sweep.grid.axes)
    if count not in (1, 2):
        raise ConfigError(
            f"a figure needs one or two axes, this sweep has {count}", possible="its numbers are in result.h5"
        )
    with_exponents = "lyapunov" in result
    with style():
        columns = 2 if count == 2 and with_exponents else 1
        figure = Figure(figsize=(PANEL[0] * columns, PANEL[1]), layout="constrained")
        axes = figure.subplots(1, columns, squeeze=False)[0]
        if count == 1:
            draw_line(axes[0], result)
        else:
            draw_regions(axes[0], result)
            if with_exponents:
                draw_largest(figure, axes[1], result)
    return figure


def draw(result: Result, path: Path | str) -> Path:
    """Draw a result into a PNG, PDF or SVG file and return its path.

    Raises
    ------
    ConfigError
        If the format is not known, or no figure suits the result.
    DiskError
        If the file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise ConfigError(
            f"no figure can be written as {path.suffix or 'a file without suffix'}", str(path), "use .png, .pdf or .svg"
        )
    figure = make_figure(result)
    metadata = (
        {} if path.suffix.lower() == ".png" else {"Date" if path.suffix.lower() == ".svg" else "CreationDate": None}
    )
    try:
        with style():
            figure.savefig(path, metadata=metadata)
    except OSError as error:
        raise DiskError(f"cannot be written: {error.strerror or error}", str(path)) from error
    return path
