"""Which figure suits a result, and writing figures into files."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from quavsweep.errors import ConfigError
from quavsweep.memory import release_memory
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.cell import make_cell_figure
from quavsweep.plot.colour import Limits
from quavsweep.plot.comparison import compare
from quavsweep.plot.line import make_line_figure
from quavsweep.plot.map import make_map_figure
from quavsweep.plot.point import make_point_figure
from quavsweep.plot.style import style
from quavsweep.plot.survival import SURVIVAL, make_survival_figure
from quavsweep.plot.thin import thinned
from quavsweep.plot.title import LINE, fixed_title, seen_text
from quavsweep.whole import binary_file

if TYPE_CHECKING:
    from quavsweep.point import Point
    from quavsweep.result import Result

FORMATS = {".png": None, ".pdf": "CreationDate", ".svg": "Date"}  # with the key of the time, which is left out


def make_figure(
    results: Result | Sequence[Result],
    *,
    variables: Sequence[str] = (),
    limits: Limits | None = None,
    overlays: Sequence[str] = (),
) -> Figure:
    """Return the figure that suits a result, or one that compares several.

    Two axes give maps, one gives panels along it, none the orbit or the numbers of the cell. Of axes with more values
    than a figure can show, every so-manyth is drawn, and the title says so.

    Parameters
    ----------
    results : Result, or sequence of them
        Several must have the same number of axes.
    variables : sequence of str
        What the panels show, such as `region`, `lyapunov.2`, `final_state.p`; by default what says most.
    limits : (float, float), optional
        Of the colours of maps, or of the vertical axis of other figures.
    overlays : sequence of str
        Curves, each an equation in the names of axes and parameters or the path of a CSV file, with a label and a
        colon in front if wanted.

    Raises
    ------
    ConfigError
        If there is no such variable or curve, the limits are not finite or do not ascend, or the sweep has more
        than two axes.
    """
    runs = list(results) if isinstance(results, Sequence) else [results]
    variables = (variables,) if isinstance(variables, str) else variables
    overlays = (overlays,) if isinstance(overlays, str) else overlays
    if limits is not None and not -math.inf < limits[0] < limits[1] < math.inf:
        raise ConfigError(f"limits must ascend and be finite, {limits[0]:g} to {limits[1]:g} is not")
    with style():
        if len(runs) == 1 and _is_survival(runs[0], variables):
            return _told(make_survival_figure(runs[0], limits), runs[0])
    variables = variables or tuple(runs[0].sweep.config.plot if len(runs) == 1 else ())
    runs = [thinned(_seen(run, variables)) for run in runs]
    count = _axes_count(runs)
    with style():
        if len(runs) > 1:
            return compare(runs, variables, limits, overlays)
        figure = (make_cell_figure, make_line_figure, make_map_figure)[count](runs[0], variables, limits, overlays)
        return _told(figure, runs[0]) if count else figure


def _is_survival(run: Result, variables: Sequence[str]) -> bool:
    """Whether survival is what is asked for, or what says most."""
    alone = run.sweep.config.ensemble is not None and run.sweep.start_axes == tuple(a.name for a in run.sweep.grid.axes)
    asked = tuple(variables) or tuple(run.sweep.config.plot)
    return SURVIVAL in asked or (not asked and alone and bool(run.sweep.grid.axes))


def _seen(run: Result, variables: Sequence[str]) -> Result:
    """Return the result over its parameter points where that has what is asked for, or says most."""
    if not run.sweep.start_axes:
        return run
    points = run.points
    if not variables:
        return points if "lifetime" in points else run
    names = Catalogue(points).names
    return points if all(variable.partition(".")[0] in names for variable in variables) else run


def _told(figure: Figure, result: Result) -> Figure:
    """Return the figure with a title that says at which values of other axes it is, and at which horizon, if any."""
    width, height = figure.get_size_inches()
    title = fixed_title(result.sweep, result.fixed, width, seen_text(result))
    if title:
        figure.set_size_inches(width, height + LINE * (title.count("\n") + 1))
        figure.suptitle(title, fontsize=8)
    return figure


def _axes_count(runs: Sequence[Result]) -> int:
    """Return how many axes all results have."""
    if not runs:
        raise ConfigError("there is no result to draw")
    counts = sorted({len(run.sweep.grid.axes) for run in runs})
    if len(counts) > 1:
        raise ConfigError(f"results with {' and '.join(map(str, counts))} axes do not fit into one figure")
    for run in runs:
        names = [axis.name for axis in run.sweep.grid.axes]
        if len(names) > 2:
            what = f"a figure has at most two axes, this sweep has {len(names)}: {', '.join(names)}"
            raise ConfigError(what, possible="choose values of the others with --at KEY=VALUE")
    return counts[0]


def draw(
    results: Result | Sequence[Result],
    path: Path | str,
    *,
    variables: Sequence[str] = (),
    limits: Limits | None = None,
    overlays: Sequence[str] = (),
) -> Path:
    """Draw results, as `make_figure` does, into a PNG, PDF or SVG file and return its path.

    Raises
    ------
    ConfigError
        If the format is not known, or no figure suits what is asked for.
    DiskError
        If the file cannot be written.
    """
    path = _validate_path(path)
    figure = make_figure(results, variables=variables, limits=limits, overlays=overlays)
    release_memory()  # a map is made of arrays as large as the grid, and saved with others
    return save_figure(figure, path)


def picture(result: Result) -> bytes:
    """Return the figure of a result as a PNG, for notebooks."""
    buffer = io.BytesIO()
    with style():
        make_figure(result).savefig(buffer, format="png", dpi=150)
    return buffer.getvalue()


def draw_point(point: Point, path: Path | str, variables: Sequence[str] = ()) -> Path:
    """Draw a single cell, and some states or observables as `orbit.p`, into a PNG, PDF or SVG file; return its path.

    Raises
    ------
    ConfigError
        If the format is not known, or there is no such state or observable.
    DiskError
        If the file cannot be written.
    """
    path = _validate_path(path)
    return save_figure(make_point_figure(point, variables), path)


def _validate_path(path: Path | str) -> Path:
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise ConfigError(
            f"no figure can be written as {path.suffix or 'a file without suffix'}", str(path), "use .png, .pdf or .svg"
        )
    return path


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure into a file, the same bytes each time."""
    suffix = path.suffix.lower()
    date = FORMATS[suffix]
    with binary_file(path) as raw, style():
        _lay_out(figure)
        figure.savefig(raw, format=suffix[1:], metadata={date: None} if date else {})
    return path


def _lay_out(figure: Figure) -> None:
    """Place the axes of a figure for good, at rounded positions.

    The last digits of what matplotlib's solver finds depend on where its variables lie in memory. Maps fill their axes
    whatever they show, so they are not drawn yet: each would hold 32 bytes per cell from then on.
    """
    maps = [mesh for mesh in figure.findobj(QuadMesh) if mesh.get_visible()]
    for mesh in maps:
        mesh.set_visible(False)
    figure.draw_without_rendering()
    for mesh in maps:
        mesh.set_visible(True)
    figure.set_layout_engine("none")
    for axes in figure.axes:
        bounds = axes.get_position(original=True).bounds
        axes.set_position(Bbox.from_bounds(*(round(float(length), 7) for length in bounds)))
