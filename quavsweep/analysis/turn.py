"""Turns of a series that is stored at even times: its maxima and minima, found between the times."""

from __future__ import annotations

import numpy as np

BESIDE = 3  # values on either side of a turn through which a polynomial is laid
NEWTON = 8


def turns(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values of the turns of a series, in order of time.

    Parameters
    ----------
    time, values : (n,) float64
        Evenly spaced, so finely that a polynomial of degree 6 through seven neighbours follows the course.

    Returns
    -------
    time, value : (k,) float64
        Turns less than three places from an end of the series are left out.
    """
    rise = np.diff(values)
    places = 1 + np.flatnonzero(rise[:-1] * rise[1:] < 0)
    places = places[(places >= BESIDE) & (places < len(values) - BESIDE)]
    x, (at, value) = np.arange(-BESIDE, BESIDE + 1), np.zeros((2, len(places)))
    for k, i in enumerate(places):
        course = np.polynomial.Polynomial.fit(x, values[i + x], 2 * BESIDE)
        slope, bend, s = course.deriv(), course.deriv(2), 0.0
        for _ in range(NEWTON):
            s -= slope(s) / bend(s)
        at[k], value[k] = s, course(s)
    return time[places] + at * (time[1] - time[0]), value
