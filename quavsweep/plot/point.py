"""The figure of a single cell: its orbit, how its exponents settle, and the spectrum of its first state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec, SubplotSpec

from quavsweep.codes import Region
from quavsweep.errors import ConfigError
from quavsweep.kernels.observe import observe
from quavsweep.nearest import nearest
from quavsweep.plot.convergence import convergence_handles, draw_convergence
from quavsweep.plot.legend import legend_above, legend_height
from quavsweep.plot.orbit import add_orbit, orbit_height
from quavsweep.plot.series import draw_course
from quavsweep.plot.spectrum import draw_spectrum
from quavsweep.plot.style import PAGE, style, with_unit
from quavsweep.plot.title import LINE, cell_title
from quavsweep.plot.trace import Trace

if TYPE_CHECKING:
    from quavsweep.point import Point

LOWER = 2.2  # inches of the lower row, without its legend
WIDTH = 2.9  # inches of that
COURSE = 1.3  # inches of a row of its own
ROOM = 16  # characters beside it


def make_point_figure(point: Point, variables: Sequence[str] = ()) -> Figure:
    """Return the figure of a single cell, with a row for each of some states or observables, as `orbit.p`.

    Raises
    ------
    ConfigError
        If there is no such state or observable.
    """
    trace, names = point_trace(point), [_course_name(point, variable) for variable in variables]
    title = cell_title(point.sweep, point.orbit[0], int(point.values["region"]), PAGE, point.chosen)
    with style():
        lower = LOWER + legend_height(convergence_handles(point), WIDTH)
        heights = [orbit_height(trace), *(COURSE for _ in names), lower]
        figure = Figure(figsize=(PAGE, sum(heights) + LINE * (title.count("\n") + 1)), layout="constrained")
        figure.suptitle(title, fontsize=8)
        rows = GridSpec(len(heights), 1, figure, height_ratios=heights)
        add_orbit(figure, rows[0], trace)
        for i, name in enumerate(names, 1):
            axes = figure.add_subplot(rows[i])
            draw_course(axes, trace, _course(point, trace, name), name, ROOM)
            axes.set_xlabel(with_unit("$t$", trace.model.time_unit))
        _add_lower(figure, rows[-1], point, trace)
    return figure


def _course_name(point: Point, variable: str) -> str:
    """Return the state or observable that a variable means."""
    model = point.sweep.model
    names = [f"orbit.{name}" for name in (*model.state_names, *model.observable_names)]
    if variable not in names:
        possible = f"possible are {', '.join(names)}"
        raise ConfigError(f"no variable {variable} to draw{nearest(variable, names)}", possible=possible)
    return variable.partition(".")[2]


def _course(point: Point, trace: Trace, name: str) -> np.ndarray:
    """Return a state or observable along the orbit of a cell, (n,)."""
    model = trace.model
    if name in model.state_names:
        return np.asarray(trace.shown[:, model.state_names.index(name)])
    return observe(model, [name], trace.shown, point.sweep.parameters, point.time)[:, 0]


def _add_lower(figure: Figure, place: SubplotSpec, point: Point, trace: Trace) -> None:
    """Draw how the exponents settle, if there are any, and the spectrum."""
    with_exponents = point.exponents.shape[1] > 0
    halves = place.subgridspec(1, 2 if with_exponents else 1)
    if with_exponents:
        axes = figure.add_subplot(halves[0])
        draw_convergence(axes, point)
        legend_above(axes, convergence_handles(point), WIDTH)
    spacing = point.time[1] - point.time[0] if len(point.time) > 1 else 1.0
    draw_spectrum(figure.add_subplot(halves[-1]), trace.model, trace.shown[trace.late :, 0], float(spacing))


def point_trace(point: Point) -> Trace:
    """Return the orbit of a cell with what is known of its parts."""
    sink = int(point.values["region"]) == Region.SINK
    return Trace(
        point.sweep.model,
        point.time,
        point.orbit,
        point.sweep.clock.transient,
        np.asarray(point.values["equilibrium"]) if sink else None,
    )
