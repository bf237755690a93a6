"""Maxima of a series: place and height of the parabola through the highest of three values."""

from __future__ import annotations

import numpy as np


def maxima(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the inner maxima of a series at even times.

    Parameters
    ----------
    values : (n,) float64

    Returns
    -------
    place : (m,) float64
        Where they are, in steps from the first value, ascending.
    height : (m,) float64
        Their values, in the series' unit.

    Notes
    -----
    With f(-1), f(0), f(1) around the highest value, s = (f(1) - f(-1)) / 2 and b = f(1) - 2 f(0) + f(-1) < 0, the
    parabola is highest at -s / b, by -s^2 / (2 b) above f(0).
    """
    middle = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
    before, at, after = values[middle - 1], values[middle], values[middle + 1]
    slope, bend = 0.5 * (after - before), after - 2.0 * at + before
    return middle - slope / bend, at - 0.5 * slope**2 / bend
