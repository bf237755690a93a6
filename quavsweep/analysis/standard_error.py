"""The standard error of the mean of a correlated series, from the low end of its spectrum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FEWEST = 8  # values; fewer do not tell an error
BANDS = ((10, 12), (16, 8), (24, 5))  # frequencies that are looked at: at least so many, or one in so many values
WIDEST = 64  # frequencies
CAP = 2.0  # a line of the spectrum counts as no more than so many times the fit
ROUNDS = 6  # of reweighting; the last one changes a variance by a percent or less
SMALLEST = 1e-30  # value of the fit, against the mean power
SMALL_SAMPLE = 4.0  # the variance is raised by so much over the number of frequencies: see below


@dataclass(frozen=True)
class Noise:
    """What the mean of a series scatters by: two variances, (...) each, in the unit of the values squared.

    Parameters
    ----------
    lasting : (...) float64
        Variance s of the part that adds up; infinite where too few values tell it.
    bounded : (...) float64
        Variance v of the quantity of which the rest are differences.
    """

    lasting: np.ndarray
    bounded: np.ndarray

    def error(self, n: int) -> np.ndarray:
        """Return the standard error of the mean of n values, (...)."""
        return np.asarray(np.sqrt((self.lasting + self.bounded * 2.0 / n) / n))


def noise_of(series: np.ndarray) -> Noise:
    """Return what the means of series scatter by.

    Parameters
    ----------
    series : (..., N) float64
        Values at even times, each an average over a stretch between two of them.

    Notes
    -----
    The series is taken for independent increments, with variance s, plus differences of a bounded quantity, with
    variance v: the growth of a tangent vector is of that kind, for what the frame lags behind the flow in one batch
    it makes up for in the next. Its periodogram is then I_k = a + b z_k on average, a = s + c and b = v, with
    z_k = 4 sin^2(pi k / N) + 2 / N, where 2 / N comes from the two ends. The mean has the variance
    (a + 2 b / N) / N, so the error of a bounded quantity falls as 1 / N, that of others as 1 / sqrt(N).

    a, b >= 0 are fitted with weights 1 / (a + b z_k)^2 (Whittle's likelihood) to the lowest frequencies alone, so
    correlations over several values are seen. A periodic part makes a line, not a variance of the mean: each I_k counts
    as at most twice the fit, corrected for what that takes from exponentially distributed ones. Lines still bend the
    fit, and where they lie depends on the length of a value; so three bands are fitted and their variances averaged.
    Two parameters from M frequencies are too small by about 1 - 4 / M (white series of 16 to 256 values), which is
    made up for.

    References
    ----------
    .. [1] P. Heidelberger and P. D. Welch, Commun. ACM 24, 233 (1981): low frequencies of the periodogram.
    """
    series = np.ascontiguousarray(series, dtype=np.float64)
    n, shape = series.shape[-1], series.shape[:-1]
    if n < FEWEST:
        return Noise(np.full(shape, np.inf), np.zeros(shape))
    bands = sorted({min((n - 1) // 2, max(fewest, min(WIDEST, n // share))) for fewest, share in BANDS})
    centred = series - series.mean(axis=-1, keepdims=True)
    spectrum = np.fft.rfft(centred, axis=-1)[..., 1 : bands[-1] + 1]
    power = (spectrum.real**2 + spectrum.imag**2) / n
    z = 4.0 * np.sin(np.pi * np.arange(1, bands[-1] + 1) / n) ** 2 + 2.0 / n
    lasting, bounded = np.zeros(shape), np.zeros(shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        for m in bands:
            a, b = _fitted(np.ascontiguousarray(power[..., :m]), z[:m])
            lasting += a * (1.0 + SMALL_SAMPLE / m) / len(bands)
            bounded += b / len(bands)
    return Noise(lasting, bounded)


def _fitted(power: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a and b >= 0 for which power is exponentially distributed around a + b z, (...) each."""
    scale = power.mean(axis=-1)
    power = power / np.where(scale > 0, scale, 1.0)[..., None]
    a = np.median(power, axis=-1) / (2.0 * np.log(2.0))
    b = a / z.mean()
    for _ in range(ROUNDS):
        fit = np.maximum(a[..., None] + b[..., None] * z, SMALLEST)
        weight = fit**-2.0
        capped = np.minimum(power, CAP * fit) / (1.0 - np.exp(-CAP))
        s0, s1, s2 = weight.sum(axis=-1), (weight * z).sum(axis=-1), (weight * z * z).sum(axis=-1)
        t0, t1 = (weight * capped).sum(axis=-1), (weight * capped * z).sum(axis=-1)
        free = s0 * s2 - s1 * s1
        a, b = (t0 * s2 - t1 * s1) / free, (s0 * t1 - s1 * t0) / free
        a, b = (
            np.where(a < 0, 0.0, np.where(b < 0, t0 / s0, a)),
            np.where(a < 0, t1 / s2, np.where(b < 0, 0.0, b)),
        )
    return a * scale, b * scale
