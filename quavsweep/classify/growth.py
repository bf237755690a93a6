"""Averages of stored growth over windows of whole batches, each cell with its own window."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from quavsweep.analysis.standard_error import noise_of
from quavsweep.classify.window import Window
from quavsweep.clock import Clock
from quavsweep.measures import Evidence

ALL = slice(None)  # exponents
LARGEST = slice(0, 1)


@dataclass(frozen=True)
class Average:
    """Averages of the growth over a window per cell; NaN where the window is empty.

    Parameters
    ----------
    rate : (n, K) float64
        Exponents [1/time].
    error : (n, K) float64
        Their standard errors [1/time]; infinite where there are fewer than eight batches.
    departure : (n, K) float64
        F, the largest distance of the sum of growth from its straight line through both ends of the window.
    time : (n,) float64
        Length of the window, in the model's time.
    """

    rate: np.ndarray
    error: np.ndarray
    departure: np.ndarray
    time: np.ndarray

    @classmethod
    def empty(cls, n: int, exponents: int) -> Average:
        """Return the averages of n cells whose window is empty."""
        rate, error, departure = (np.full((n, exponents), np.nan) for _ in range(3))
        return cls(rate, error, departure, np.zeros(n))


@dataclass(frozen=True)
class Growth:
    """Sums of ln of the stretching along orbits.

    Parameters
    ----------
    path : (n, K, B + 1) float64
        The sums from t = 0 to the end of each batch, the first of them 0; NaN where a cell was not integrated.
    batch : float
        Length of a batch, in the model's time.
    """

    path: np.ndarray
    batch: float

    def over(self, window: Window, exponents: slice = ALL, wanted: np.ndarray | None = None) -> Average:
        """Return averages over a window per cell; errors, which cost most, only of the cells wanted, (n,) bool."""
        return self.over_last(window, (1,), exponents, wanted)[0]

    def over_last(
        self, window: Window, parts: Sequence[int], exponents: slice = ALL, wanted: np.ndarray | None = None
    ) -> list[Average]:
        """Return averages over the last 1 / part of a window per cell, for each part, the longest first.

        What they scatter by is read off the whole window, because a part of it has too few batches to tell; and the
        error of all parts is that of the longest, which tells the sign. In a shorter one the orbit must go on so: if it
        does not, its growth is no longer as noisy either, and its departure tells.
        """
        wanted = np.ones(len(self.path), bool) if wanted is None else wanted
        n, k = self.path[:, exponents, 0].shape
        averages = [Average.empty(n, k) for _ in parts]
        for first, last, cells in _distinct(window):
            path = np.ascontiguousarray(self.path[cells, exponents, first : last + 1])
            noisy = np.flatnonzero(wanted[cells])
            noise = noise_of(np.diff(path[noisy], axis=-1))
            for part, average in zip(parts, averages, strict=True):
                length = max((last - first) // part, 1)
                average.rate[cells], average.departure[cells] = _line(path[..., -length - 1 :], self.batch)
                average.error[cells[noisy]] = noise.error(max((last - first) // parts[0], 1)) / self.batch
                average.time[cells] = length * self.batch
        return averages

    def rates(self, window: Window) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield cells of equal windows, and their rates in each batch of it, (m, K, batches)."""
        for first, last, cells in _distinct(window):
            path = np.ascontiguousarray(self.path[cells, :, first : last + 1])
            yield cells, np.diff(path, axis=-1) / self.batch

    def of(self, cells: np.ndarray) -> Growth:
        """Return the growth of some cells."""
        return Growth(self.path[cells], self.batch)


def _line(path: np.ndarray, batch: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the slope of the straight line through both ends of paths, and their departure from it, (n, K) each."""
    length = path.shape[-1] - 1
    rise = path[..., -1] - path[..., 0]
    line = path[..., :1] + rise[..., None] * (np.arange(length + 1) / length)
    return rise / (length * batch), np.abs(path - line).max(axis=-1)


def growth_of(evidence: Evidence, clock: Clock) -> Growth:
    """Return the growth of the measure `lyapunov`: exact at the ends of segments, by single precision between."""
    increments = evidence["growth"].astype(np.float64)
    n, batches, k = increments.shape
    within = increments.reshape(n, -1, clock.segment_batches, k)
    totals = evidence["growth_total"]
    path = np.zeros((n, batches + 1, k))
    ends = path[:, 1:].reshape(within.shape)
    ends[:] = within
    for i in range(1, clock.segment_batches):
        ends[:, :, i] += ends[:, :, i - 1]
    ends[:, 1:] += totals[:, :-1, None]
    ends[:, :, -1] = totals
    return Growth(np.ascontiguousarray(np.moveaxis(path, 1, 2)), clock.batch_steps * clock.dt)


def late_growth_of(evidence: Evidence, clock: Clock) -> Growth:
    """Return the growth of the measure `verdict`: one vector, from the end of the run on."""
    late = evidence["late_growth"].astype(np.float64)
    path = np.concatenate([np.zeros((len(late), 1)), late.cumsum(axis=1)], axis=1)
    return Growth(path[:, None], clock.batch_steps * clock.dt)


def _distinct(window: Window) -> Iterator[tuple[int, int, np.ndarray]]:
    """Yield every window that is not empty, and the cells that have it."""
    windows, which = np.unique(np.stack(window, axis=1), axis=0, return_inverse=True)
    for number, (first, last) in enumerate(windows):
        if last > first:
            yield int(first), int(last), np.flatnonzero(which.ravel() == number)
