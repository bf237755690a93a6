"""Fewer vertices for long lines, such that figures stay small and look the same."""

from __future__ import annotations

import numpy as np

MOST = 4000  # vertices of a line against time: several per dot of print
MOST_ORBIT = 20000  # vertices of an orbit in space


def extremes(values: np.ndarray, most: int = MOST) -> np.ndarray:
    """Return the indices of the lowest and the highest value of each of many windows, in order.

    All indices where there are no more than `most`; values that are no numbers are never an extreme of a window that
    has numbers.
    """
    n = len(values)
    if n <= most:
        return np.arange(n)
    length = -(-n // (most // 2))
    starts = np.arange(0, n, length)
    padded = np.full(len(starts) * length, np.nan)
    padded[:n] = values
    windows = padded.reshape(-1, length)
    low = np.where(np.isfinite(windows), windows, np.inf).argmin(axis=1) + starts
    high = np.where(np.isfinite(windows), windows, -np.inf).argmax(axis=1) + starts
    return np.unique(np.concatenate([low, high, [0, n - 1]]))


def strided(n: int, most: int = MOST_ORBIT) -> np.ndarray:
    """Return at most so many evenly spaced indices, the last one among them."""
    stride = max(1, -(-n // most))
    return np.arange((n - 1) % stride, n, stride)
