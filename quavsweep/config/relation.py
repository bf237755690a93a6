"""Relations that a physical system obeys, checked over the whole grid."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from quavsweep.grid import Axis, Grid
from quavsweep.models import Model, Relation
from quavsweep.models.mistake import mistake

MAX_POINTS = 4_000_000  # at which a relation is evaluated


def broken_relations(model: Model, fixed: Mapping[str, float], grid: Grid) -> tuple[str, ...]:
    """Return a sentence for each relation of the model that some cell breaks."""
    sentences = (_sentence(relation, fixed, grid) for relation in model.relations)
    return tuple(sentence for sentence in sentences if sentence)


def _sentence(relation: Relation, fixed: Mapping[str, float], grid: Grid) -> str:
    """Return what is broken and where, empty if the relation holds."""
    axes = [axis for axis in grid.axes if set(axis.quantities) & set(relation.parameters)]
    exact = math.prod(len(axis) for axis in axes) <= MAX_POINTS
    most = MAX_POINTS if exact else max(2, int(MAX_POINTS ** (1 / len(axes))))
    mesh = np.meshgrid(*(_sample(axis, most) for axis in axes), indexing="ij", sparse=True)
    varied = {
        name: np.asarray(values)[part]
        for axis, part in zip(axes, mesh, strict=True)
        for name, values in axis.quantities.items()
    }
    values = {name: varied.get(name, fixed.get(name)) for name in relation.parameters}
    try:
        holds = np.asarray(relation.holds(**values))
    except Exception as error:  # whatever a user's function may raise
        raise mistake(error, relation.holds) from error
    if holds.all():
        return ""
    about = "" if exact else "about "
    share = f" in {about}{100 * (1 - holds.mean()):.3g} % of the cells" if axes else ""
    return f"{relation.text} does not hold{share}; {relation.meaning}"


def _sample(axis: Axis, most: int) -> np.ndarray:
    """Return the indices of at most so many values of an axis, evenly chosen, with both ends."""
    return np.linspace(0, len(axis) - 1, min(most, len(axis))).round().astype(int)
