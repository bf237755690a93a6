"""Where the slope of a path falls: the end of a phase of growth, its slopes unknown or known."""

from __future__ import annotations

import numpy as np


def last_of_growth(path: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return where each path most likely changes from one slope to a smaller one.

    Parameters
    ----------
    path : (n, N) float64
        Sums of independent increments; only the part first .. last counts, the rest may be NaN.
    first, last : (n,) int
        Indices of both ends.

    Returns
    -------
    (n,) int
        An index between the ends; `first` where no part between them lies above the straight line.

    Notes
    -----
    Where a path lies above the straight line through its ends by d, after m of N increments, the likelihood of a
    change of the mean there grows with d^2 N / (m (N - m)).
    """
    index = np.arange(path.shape[1])
    first, last = first[:, None], last[:, None]
    length = np.maximum(last - first, 1)
    done = index - first
    inside = (done > 0) & (index < last)
    begin = np.take_along_axis(path, first, axis=1)
    rise = np.take_along_axis(path, last, axis=1) - begin
    above = path - begin - rise * (done / length)
    spread = np.sqrt(np.where(inside, done * (length - done), 1))
    score = np.where(inside & (above > 0), above / spread, 0.0)
    best = score.argmax(axis=1)
    return np.where(score[np.arange(len(path)), best] > 0, best, first[:, 0])


def end_of_slope(path: np.ndarray, first: np.ndarray, last: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Return where each path most likely changes from one known slope to a smaller one, (n,) int.

    Parameters
    ----------
    path, first, last
        As above; both ends are possible answers.
    middle : (n,) float64
        The mean of both slopes, per increment. The likelihood of a change at an index grows with the height of the path
        there above a line of this slope.
    """
    index = np.arange(path.shape[1])
    inside = (index >= first[:, None]) & (index <= last[:, None])
    return np.asarray(np.where(inside, path - middle[:, None] * index, -np.inf).argmax(axis=1))
