"""Axes of figures: linear or logarithmic, labelled, with the borders of the cells along them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axis import XAxis, YAxis
from matplotlib.ticker import AutoLocator, Formatter, LogLocator, MaxNLocator, NullFormatter

from quavsweep.grid import Axis
from quavsweep.models import Model
from quavsweep.plot.along import axis_text
from quavsweep.plot.style import LABEL_WIDTH, power_of, text_length, with_unit

MOST_DECIMALS = 8
DECADES = 30.0  # a logarithmic axis with more between its ends has a tick per decade
INTERVALS = 6  # between ticks along a horizontal axis, so that texts such as 0.125 do not touch
FEW = 4.0  # one with less has ticks at even distances


def set_scale(axis: XAxis | YAxis, model: Model, quantity: Axis) -> None:
    """Scale and label an axis of a figure as an axis of a sweep.

    A common power of ten goes into the label, because matplotlib's own place for it is where the legend is.
    """
    values = np.asarray(quantity.values)
    ratio = values.max() / values.min() if is_log(quantity) else 1.0
    if is_log(quantity):
        (axis.axes.set_xscale if isinstance(axis, XAxis) else axis.axes.set_yscale)("log")
        axis.set_minor_formatter(NullFormatter())
    if ratio >= DECADES:
        axis.set_label_text(axis_text(model, quantity))
        return
    if is_log(quantity):
        axis.set_major_locator(AutoLocator() if ratio < FEW else LogLocator(subs=(1.0, 2.0, 5.0)))
    elif isinstance(axis, XAxis):
        axis.set_major_locator(MaxNLocator(INTERVALS, steps=[1, 2, 5, 10]))
    power = power_of(values)
    set_power(axis, power)
    axis.set_label_text(axis_text(model, quantity, power))


def set_values(
    axis: XAxis | YAxis, values: np.ndarray, text: str, unit: str, room: int = LABEL_WIDTH, log: bool = False
) -> None:
    """Label an axis that shows values; a common power of ten goes into the label.

    The unit goes into a line of its own where a label has more characters than there is room for.
    """
    power = 0 if log else power_of(values)
    if not log:
        set_power(axis, power)
    words = with_unit(text, unit, power)
    axis.set_label_text(words.replace(" ($", "\n($") if text_length(words) > room else words)


def set_power(axis: XAxis | YAxis, power: int) -> None:
    """Write the ticks of an axis without a common power of ten."""
    axis.set_major_formatter(PowerFormatter(power))


class PowerFormatter(Formatter):
    """Ticks without a common power of ten, all with as many decimals as one of them needs."""

    def __init__(self, power: int) -> None:
        self._power = power

    def __call__(self, value: float, position: int | None = None) -> str:
        """Return the text of a single tick."""
        return self.format_ticks([value])[0]

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        """Return the texts of all ticks of an axis."""
        numbers = np.asarray(values, dtype=np.float64) / 10.0**self._power
        step = float(np.min(np.diff(np.unique(numbers)), initial=np.inf))
        exact = 1e-3 * (step if np.isfinite(step) else float(np.abs(numbers).max(initial=1.0)))
        decimals = next((n for n in range(MOST_DECIMALS) if (abs(np.round(numbers, n) - numbers) <= exact).all()), 8)
        return [f"{number + 0.0:.{decimals}f}".replace("-", "\N{MINUS SIGN}") for number in np.round(numbers, decimals)]


def edges(values: np.ndarray) -> np.ndarray:
    """Return the borders of cells around ascending values, (n + 1,): midway, and as far beyond the ends.

    Midway in the logarithm where the values are spaced so.
    """
    if axis_is_log(values):
        return np.asarray(np.exp(edges(np.log(values))))
    if len(values) == 1:
        width = abs(values[0]) * 0.5 or 0.5
        return np.array([values[0] - width, values[0] + width])
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def drawn_range(axis: Axis) -> tuple[float, float]:
    """Return where the cells along an axis of a sweep begin and end in a figure."""
    borders = edges(np.sort(axis.values))
    return float(borders[0]), float(borders[-1])


def is_log(axis: Axis) -> bool:
    """Whether an axis of a sweep is drawn logarithmically."""
    return axis_is_log(np.sort(axis.values))


def axis_is_log(values: np.ndarray) -> bool:
    """Whether values are spaced evenly in their logarithm and not in themselves."""
    if len(values) < 3 or (values <= 0).any():
        return False
    return bool(np.allclose(np.diff(np.log(values)), np.log(values[1] / values[0]), rtol=1e-6)) and not bool(
        np.allclose(np.diff(values), values[1] - values[0], rtol=1e-6)
    )
