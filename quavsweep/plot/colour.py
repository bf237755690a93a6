"""From numbers to colours: codes, signed rates with a white zero, other numbers from dark to light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, ListedColormap, LogNorm, Normalize, TwoSlopeNorm

from quavsweep.plot.code import code_colours
from quavsweep.plot.quantity import Quantity

RATES = "RdBu_r"  # blue below zero, white at zero, red above
SIGNED = "PuOr_r"
SEQUENCE = "viridis"
UNEVEN = 10.0  # the ratio of the two slopes at most, lest errors of one side look like values of the other
OUTLYING = 2.0  # values are cut off that lie so many times the range of the inner 98 % beyond it
Limits = tuple[float, float]


@dataclass(frozen=True)
class ColourScale:
    """Colour map and norm, and what a colour bar needs.

    `ticks` is empty where matplotlib may choose them; `extend` says on which side values lie beyond the scale:
    `neither`, `min`, `max` or `both`.
    """

    colours: Colormap
    norm: Normalize
    ticks: tuple[float, ...] = ()
    extend: str = "neither"


def choose_scale(quantities: Sequence[Quantity], limits: Limits | None) -> ColourScale:
    """Return the scale of one quantity of one or several results."""
    if quantities[0].codes:
        return ColourScale(*code_colours(quantities[0].codes))
    values = np.concatenate([quantity.shown.ravel() for quantity in quantities])
    values = values[np.isfinite(values)]
    if quantities[0].log:
        bounds = np.concatenate(
            [[], *(quantity.bound.ravel() for quantity in quantities if quantity.bound is not None)]
        )
        told = values if (values > 0).any() else bounds
        if (told > 0).any():
            return _extended(_logarithmic(told[told > 0], limits), np.concatenate([values, bounds]))
    if quantities[0].share and limits is None:
        return ColourScale(mpl.colormaps[SEQUENCE], Normalize(0.0, 1.0))
    if limits is not None:
        scale = _limited(limits, quantities[0].rate, values)
    else:
        scale = _rates(values) if quantities[0].rate else _numbers(values)
    return _extended(scale, values)


def _rates(values: np.ndarray) -> ColourScale:
    """Return a scale on which each side of zero has its own slope, since rates of sinks and chaos differ in size."""
    low = _round_limit(-values) or _round_limit(values) or 1.0
    high = _round_limit(values) or low
    return _two_slopes(RATES, -max(low, high / UNEVEN), max(high, low / UNEVEN))


def _numbers(values: np.ndarray) -> ColourScale:
    """Return a scale for numbers of any kind: even on both sides of zero if they have both signs."""
    low, high = _range(values)
    both = low < 0 < high and min(-low, high) > 0.01 * max(-low, high)
    if both:
        largest = max(-low, high)
        return _two_slopes(SIGNED, -largest, largest)
    return ColourScale(mpl.colormaps[SEQUENCE], Normalize(low, high))


def _logarithmic(values: np.ndarray, limits: Limits | None) -> ColourScale:
    """Return a scale on which equal ratios look alike."""
    low, high = limits if limits is not None and limits[0] > 0 else _range(values)
    return ColourScale(mpl.colormaps[SEQUENCE], LogNorm(low, high))


def _limited(limits: Limits, rate: bool, values: np.ndarray) -> ColourScale:
    """Return a scale between given limits; where its colours tell the sign, white is still zero."""
    low, high = limits
    name = RATES if rate else SIGNED
    if not rate and not ((values < 0).any() and (values > 0).any()):
        return ColourScale(mpl.colormaps[SEQUENCE], Normalize(low, high))
    if low < 0 < high:
        return _two_slopes(name, low, high)
    largest = max(abs(low), abs(high))
    side = np.linspace(0.5 + 0.5 * low / largest, 0.5 + 0.5 * high / largest, 256)
    return ColourScale(ListedColormap(mpl.colormaps[name](side)), Normalize(low, high))


def _two_slopes(name: str, low: float, high: float) -> ColourScale:
    return ColourScale(mpl.colormaps[name], TwoSlopeNorm(0.0, low, high), (low, 0.5 * low, 0.0, 0.5 * high, high))


def _extended(scale: ColourScale, values: np.ndarray) -> ColourScale:
    below, above = (values < scale.norm.vmin).any(), (values > scale.norm.vmax).any()
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    return ColourScale(scale.colours, scale.norm, scale.ticks, extend[bool(below), bool(above)])


def _range(values: np.ndarray) -> Limits:
    """Return where a scale begins and ends: at the extremes, but not at those of a few that lie far out."""
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    inner_low = float(np.percentile(values, 1, method="higher"))
    inner_high = float(np.percentile(values, 99, method="lower"))
    reach = OUTLYING * (inner_high - inner_low)
    if reach > 0:
        low = inner_low if inner_low - low > reach else low
        high = inner_high if high - inner_high > reach else high
    if low == high:
        margin = 0.5 * abs(low) or 0.5
        return low - margin, high + margin
    return low, high


def _round_limit(values: np.ndarray) -> float:
    """Return a round number that all but one in 200 of the positive values stay below; 0 if there are none."""
    positive = values[values > 0]
    if not positive.size:
        return 0.0
    top = float(np.percentile(positive, 99.5))
    unit = 10.0 ** np.floor(np.log10(top))
    return float(unit * np.ceil(top / unit * 5 - 1e-9) / 5)
