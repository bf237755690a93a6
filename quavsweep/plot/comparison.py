"""Several results in one figure: a panel for each, with one legend and one scale of colours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.errors import ConfigError
from quavsweep.plot.band import HEIGHT, band_handles, draw_band
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.cell import draw_part, possible_parts, region_text
from quavsweep.plot.code import code_handles, mask_handles
from quavsweep.plot.colour import Limits, choose_scale
from quavsweep.plot.legend import legend_height, legend_outside
from quavsweep.plot.map import default_variables, draw_bar, draw_map
from quavsweep.plot.overlay import draw_curves, make_curves
from quavsweep.plot.panel import choose_panels, draw_panel, panel_handles
from quavsweep.plot.quantity import Quantity
from quavsweep.plot.style import PAGE, PANEL, plain
from quavsweep.plot.title import seen_text

if TYPE_CHECKING:
    from quavsweep.result import Result

COLUMNS = 3
STACKED = 1.7  # inches of a panel among others
TITLE = 0.25


def compare(runs: Sequence[Result], variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]) -> Figure:
    """Return a figure with a panel for each result, all with the same number of axes.

    Raises
    ------
    ConfigError
        If more than one variable is asked for, or one that a result does not have.
    """
    if len(variables) > 1:
        raise ConfigError(f"several results are compared in one variable, not in {', '.join(variables)}")
    suited = (_compare_cells, _compare_lines, _compare_maps)
    return suited[len(runs[0].sweep.grid.axes)](runs, variables, limits, overlays)


def _compare_maps(
    runs: Sequence[Result], variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]
) -> Figure:
    """Return maps of one variable, by default of the region, or of what says most of parameter points."""
    natural = "region" if "region" in runs[0] else default_variables(runs[0])[0]
    quantities = [Catalogue(run).find(variables[0] if variables else natural) for run in runs]
    scale = choose_scale(quantities, limits)
    curves = make_curves(overlays, [run.sweep for run in runs])
    below = [curve.handle for curve in curves[0]]
    above = _map_handles(quantities)
    figure, grid = _grid(runs, legend_height(above, PAGE) + legend_height(below, PAGE))
    meshes = [draw_map(axes, run, q, scale) for axes, run, q in zip(grid, runs, quantities, strict=True)]
    for axes, over in zip(grid, curves, strict=True):
        draw_curves(axes, over)
    if all(run.sweep.grid.axes == runs[0].sweep.grid.axes for run in runs):
        _label_outer(grid)
    if not quantities[0].codes and not all(quantity.empty for quantity in quantities):
        draw_bar(figure, meshes[0], grid, quantities[0], scale)
    legend_outside(figure, above, "upper")
    legend_outside(figure, below, "lower")
    return figure


def _map_handles(quantities: Sequence[Quantity]) -> list[Artist]:
    """Return a legend's patches for codes that are present in any map, or for cells without number."""
    values, todo, void = (
        np.concatenate([getattr(q, name).ravel() for q in quantities]) for name in ("values", "todo", "void")
    )
    codes = quantities[0].codes
    return code_handles(values, codes, todo) if codes else mask_handles(todo, void)


def _columns(count: int) -> int:
    """Return the number of panels beside each other."""
    return 2 if count in (2, 4) else min(COLUMNS, count)


def _grid(runs: Sequence[Result], extra: float) -> tuple[Figure, list[Axes]]:
    """Return a figure with a titled panel for each run, and some inches of height for legends."""
    columns = _columns(len(runs))
    rows = -(-len(runs) // columns)
    height = PANEL[1] if columns < COLUMNS else 0.8 * PANEL[1]
    figure = Figure(figsize=(PAGE, height * rows + extra), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[len(runs) :]:
        axes.remove()
    for axes, run in zip(grid, runs, strict=False):
        axes.set_title(_name(run))
    return figure, list(grid[: len(runs)])


def _name(run: Result) -> str:
    """Return the name of a run, and at which horizon and how many of its cells are seen, if not all."""
    seen = seen_text(run)
    return plain(run.sweep.name) + (f",\n{seen}" if seen else "")


def _label_outer(grid: Sequence[Axes]) -> None:
    """Leave out labels between panels that have the same axes."""
    columns = _columns(len(grid))
    for i, axes in enumerate(grid):
        if i + columns < len(grid):
            axes.tick_params(labelbottom=False)
            axes.set_xlabel("")
        if i % columns:
            axes.tick_params(labelleft=False)
            axes.set_ylabel("")


def _compare_lines(
    runs: Sequence[Result], variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]
) -> Figure:
    """Return panels under each other, each with its band of regions."""
    panels = [choose_panels(run, variables)[0] for run in runs]
    curves = make_curves(overlays, [run.sweep for run in runs])
    banded = [run for run in runs if "region" in run]
    handles = {str(handle.get_label()): handle for run in banded for handle in band_handles(run)}
    above = [*panel_handles(max(panels, key=len)), *handles.values()]
    below = [curve.handle for curve in curves[0]]
    height = (STACKED + TITLE) * len(runs) + legend_height(above, PANEL[0]) + legend_height(below, PANEL[0]) + 0.3
    figure = Figure(figsize=(PANEL[0], height), layout="constrained")
    grid = figure.subplots(len(runs), 1, squeeze=False)[:, 0]
    for axes, run, panel, over in zip(grid, runs, panels, curves, strict=True):
        draw_panel(axes, run, panel, limits, over)
        if "region" in run:
            draw_band(axes, run, 1.2)
        axes.set_title(_name(run), y=1.0, pad=72 * HEIGHT + 3)
    legend_outside(figure, above, "upper")
    legend_outside(figure, below, "lower")
    figure.align_ylabels()
    return figure


def _compare_cells(
    runs: Sequence[Result], variables: Sequence[str], limits: Limits | None, overlays: Sequence[str]
) -> Figure:
    """Return the same numbers of each cell."""
    make_curves(overlays, [run.sweep for run in runs])
    possible = [
        part for part in ("samples", "lyapunov", "final_state") if all(part in possible_parts(run) for run in runs)
    ]
    part = variables[0] if variables else possible[0]
    if part not in possible:
        raise ConfigError(f"no variable {part} to compare", possible=f"possible are {', '.join(possible)}")
    figure, grid = _grid(runs, 0.0)
    for axes, run in zip(grid, runs, strict=True):
        draw_part(axes, run, part, limits, written_out=0)
        axes.set_title(f"{_name(run)}: {region_text(run)}")
    return figure
