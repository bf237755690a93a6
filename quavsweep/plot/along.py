"""Where the cells along an axis stand in a figure: at its values, or at those of a quantity along a curve."""

from __future__ import annotations

import numpy as np

from quavsweep.config import Sweep
from quavsweep.config.schema import ENSEMBLE
from quavsweep.grid import Axis
from quavsweep.models import Model
from quavsweep.plot.style import label, number, symbol, unit_text


def drawn_axes(sweep: Sweep) -> tuple[Axis, ...]:
    """Return the axes of a sweep as they are drawn.

    A curve is drawn over the first quantity that varies along it, or over the number of its points where that comes
    back to a value.
    """
    return tuple(_drawn(axis) for axis in sweep.grid.axes)


def _drawn(axis: Axis) -> Axis:
    if not axis.along or axis.name == ENSEMBLE:
        return axis
    name, values = axis.along[0]
    return Axis(name, values, axis.along) if _is_monotonic(values) else axis


def _is_monotonic(values: tuple[float, ...]) -> bool:
    steps = np.diff(values)
    return bool((steps > 0).all() or (steps < 0).all())


def axis_text(model: Model, axis: Axis, power: int = 0) -> str:
    """Return the label of an axis that is drawn, with a power of ten that its values lack.

    Along a curve it says in a second line what the other quantities are from its left to its right.
    """
    if axis.name == ENSEMBLE:
        return "start"
    own = (
        f"point of {axis.name}" if axis.along and axis.name not in dict(axis.along) else label(model, axis.name, power)
    )
    left, right = (int(pick(axis.values)) for pick in (np.argmin, np.argmax))
    others = [_range(model, name, values, left, right) for name, values in axis.along if name != axis.name]
    return own + ("\n" + ", ".join(others) if others else "")


def _range(model: Model, name: str, values: tuple[float, ...], left: int, right: int) -> str:
    """Return what a quantity is from one end to the other, or its smallest and largest value if it turns."""
    ends = (values[left], values[right]) if _is_monotonic(values) else (min(values), max(values))
    unit = unit_text(model.quantity(name).unit)
    text = rf"{symbol(model, name)[1:-1]} = {number(ends[0])} \ldots {number(ends[1])}"
    return f"${text}" + (rf"\,{unit}$" if unit else "$")


def quantities_at(axis: Axis, positions: np.ndarray) -> dict[str, np.ndarray]:
    """Return what varies along an axis that is drawn, at some positions; curves are straight between points."""
    if not axis.along:
        return {axis.name: positions}
    order = np.argsort(axis.values)
    at = np.asarray(axis.values)[order]
    return {name: np.interp(positions, at, np.asarray(values)[order]) for name, values in axis.along}
