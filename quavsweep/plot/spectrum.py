"""The power spectrum of a state."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from quavsweep.models import Model
from quavsweep.plot.decimate import extremes
from quavsweep.plot.style import say, symbol

WEAK = 1e-6  # of the largest power; beyond the last frequency with more there is nothing to see
FEWEST = 16  # samples
ROUNDING = 1e-10  # a state that varies less than so, relative to its mean, is constant


def power_spectrum(values: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies above zero and the power there, relative to the largest.

    Parameters
    ----------
    values : (n,) float64
        A state at even times; its mean is taken off, and a Hann window laid over the rest.
    spacing : float
        Time between them.

    Returns
    -------
    (m,), (m,) float64
        Empty where there are too few samples, or they are constant.
    """
    values = values[np.isfinite(values)]
    varying = values - values.mean() if len(values) else values
    if len(values) < FEWEST or np.abs(varying).max() <= ROUNDING * np.abs(values).max():
        return np.empty(0), np.empty(0)
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(len(values)) / len(values))
    power = np.abs(np.fft.rfft(varying * window))[1:] ** 2
    return np.fft.rfftfreq(len(values), spacing)[1:], power / power.max()


def draw_spectrum(axes: Axes, model: Model, values: np.ndarray, spacing: float) -> None:
    """Draw the power spectrum of the first state up to where there is power."""
    frequency, power = power_spectrum(values, spacing)
    unit = {"1": "", "s": " (Hz)"}.get(model.time_unit, rf" ($\mathrm{{{model.time_unit}}}^{{-1}}$)")
    axes.set_xlabel(f"frequency{unit}")
    axes.set_ylabel(f"relative power of {symbol(model, model.states[0].name)}")
    if not len(power):
        axes.set(xticks=[], yticks=[])
        say(axes, "constant" if len(values) >= FEWEST else "too short")
        return
    end = int(np.flatnonzero(power > WEAK).max()) + 1
    kept = extremes(np.log10(np.maximum(power[: 2 * end], 1e-30)))
    axes.semilogy(frequency[kept], power[kept], color="black", lw=0.6)
    axes.set_xlim(0.0, 1.05 * frequency[end - 1])
    axes.set_ylim(WEAK / 10, 3.0)
