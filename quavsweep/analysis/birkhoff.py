"""Weighted Birkhoff averages: they converge fast along regular orbits, and slowly along chaotic ones.

The weights exp(-1 / (t (1 - t))), t in (0, 1) along the window, vanish with all derivatives at its ends. So the average
over N values of a quasi-periodic orbit converges faster than any power of N, over a chaotic one as 1 / sqrt(N), or as
N^(-3/2) where the values are differences of a bounded quantity.

References
----------
.. [1] S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30, 4111 (2017).
.. [2] E. Sander, J. D. Meiss, Physica D 411, 132569 (2020): the difference of two halves as a test of chaos.
"""

from __future__ import annotations

import numpy as np

FEWEST = 16  # values; fewer make no average
MOST_DIGITS = 7.0  # single precision has no more


def agreeing_digits(series: np.ndarray) -> np.ndarray:
    """Return to how many digits weighted averages over parts of each series agree.

    Parameters
    ----------
    series : (..., K, N) float64
        K quantities of each orbit at even times, of one unit, good to single precision.

    Returns
    -------
    (..., K) float64
        -log10 of the largest difference between the averages over the first, the middle and the last half, as a share
        of the standard deviation of the values; at most 7, NaN where N < 16. A difference within the single precision
        of the largest of the K quantities counts as none.
    """
    n = series.shape[-1]
    if n < FEWEST:
        return np.full(series.shape[:-1], np.nan)
    half = n // 2
    averages = np.stack([_average(series[..., i : i + half]) for i in (0, (n - half) // 2, n - half)])
    return _digits(averages.max(axis=0) - averages.min(axis=0), series)


def vanishing_digits(series: np.ndarray) -> np.ndarray:
    """Return to how many digits the weighted average over each series is zero, as `agreeing_digits`."""
    if series.shape[-1] < FEWEST:
        return np.full(series.shape[:-1], np.nan)
    return _digits(np.abs(_average(series)), series)


def _average(series: np.ndarray) -> np.ndarray:
    n = series.shape[-1]
    t = (np.arange(n) + 0.5) / n
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    return np.asarray((np.ascontiguousarray(series) * weight).sum(axis=-1) / weight.sum())


def _digits(error: np.ndarray, series: np.ndarray) -> np.ndarray:
    """Return the digits that an error leaves of a standard deviation."""
    least = 10.0**-MOST_DIGITS
    deviation = series.std(axis=-1)
    rounding = 10.0 * least * np.abs(series).max(axis=(-2, -1))[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(error <= rounding, least, error / np.maximum(deviation, rounding))
    return np.asarray(-np.log10(np.maximum(share, least)))
