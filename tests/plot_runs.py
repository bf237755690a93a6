"""Results for tests of figures: run once, and changed in memory."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Callable
from functools import cache

import numpy as np
from matplotlib.collections import QuadMesh

from quavsweep.config import parse_sweep
from quavsweep.plot import make_figure
from quavsweep.result import Result, open_result
from quavsweep.sweep import run_sweep
from tests.conftest import LORENZ, YAW

DENSE = "samples: {maxima: p, max: 4}, peak: {of: [p, r], until: 50}, first_time: {of: p, above: 0.5, until: 100}"
MAP = YAW.replace("block: 25}", f"block: 25}}, {DENSE}")
LINE = LORENZ.replace("block: 5}", "block: 5}, samples: {section: {of: z, at: 27}, max: 20}")
CELL = LINE.replace("axes:\n  rho: {start: 0.5, stop: 600, num: 60}", "parameters: {rho: 28}")


@cache
def run(text: str, name: str = "result") -> Result:
    """Return the result of a config, computed once."""
    with tempfile.TemporaryDirectory() as folder:
        result = open_result(run_sweep(parse_sweep(text), folder))
    config = result.sweep.config.model_copy(update={"name": name})
    return dataclasses.replace(result, sweep=dataclasses.replace(result.sweep, config=config))


def changed(result: Result, **data: np.ndarray) -> Result:
    """Return a result with other numbers."""
    stored = dataclasses.replace(result.stored, data={**result.stored.data, **data})
    return dataclasses.replace(result, stored=stored)


def without(result: Result, *names: str) -> Result:
    """Return a result that lacks variables."""
    parts = {
        field: {name: value for name, value in getattr(result.stored, field).items() if name not in names}
        for field in ("data", "dims", "attributes")
    }
    return dataclasses.replace(result, stored=dataclasses.replace(result.stored, **parts))


def unfinished(result: Result, where: object) -> Result:
    """Return a result some cells of which are not computed."""
    data = {name: result[name].copy() for name in result.variables}
    for array in data.values():
        array[where] = np.nan if array.dtype.kind == "f" else 0
    return changed(result, **data)


def meshes(result: Result, *variables: str, **options: object) -> list[QuadMesh]:
    """Return what is drawn of each variable over two axes, without the marks of cells that have no number."""
    figure = make_figure(result, variables=variables, **options)
    panels = figure.axes[: len(variables)]
    return [[c for c in axes.collections if isinstance(c, QuadMesh)][-1] for axes in panels]


def legend_texts(axes_or_figure: object) -> list[str]:
    """Return the texts of the legend of axes, or of all legends of a figure."""
    get: Callable[[], object] | None = getattr(axes_or_figure, "get_legend", None)
    legends = axes_or_figure.legends if get is None else [get()]
    return [text.get_text() for legend in legends for text in legend.get_texts()]
