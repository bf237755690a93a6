"""Kaplan and Yorke's dimension of an attractor, from its Lyapunov exponents."""

from __future__ import annotations

import numpy as np

Values = np.ndarray | float


def lyapunov_dimension(exponents: np.ndarray) -> np.ndarray:
    """Return j + (L_1 + ... + L_j) / |L_(j + 1)|, with the largest j for which the sum is not negative, (...).

    Parameters
    ----------
    exponents : (..., D) float64
        All exponents of a flow, largest first [1/time].

    Notes
    -----
    0 where the largest exponent is negative (a sink), D where the sum of all is not.

    References
    ----------
    .. [1] J. L. Kaplan and J. A. Yorke, Lecture Notes in Mathematics 730, 204 (1979).
    """
    sums = np.cumsum(exponents, axis=-1)
    count = (np.cumsum(sums < 0, axis=-1) == 0).sum(axis=-1)
    last = np.clip(count - 1, 0, None)[..., None]
    total = np.where(count > 0, np.take_along_axis(sums, last, axis=-1)[..., 0], 0.0)
    following = np.take_along_axis(exponents, np.clip(count, None, exponents.shape[-1] - 1)[..., None], axis=-1)[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where((count > 0) & (count < exponents.shape[-1]), total / np.abs(following), 0.0)
    return np.asarray(count + part)


def chaotic_dimension(largest: Values, divergence: Values) -> np.ndarray:
    """Return the dimension of a chaotic attractor of a flow in three dimensions, 2 + L / (L - divergence), (...).

    Parameters
    ----------
    largest : (...) float64
        Its largest exponent L > 0 [1/time].
    divergence : (...) float64
        The sum of all three [1/time], < 0.

    Notes
    -----
    The exponents are L, 0 and the rest. An error e of L makes one of e |divergence| / (L - divergence)^2.
    """
    return np.asarray(2.0 + largest / (largest - divergence))


def chaotic_dimension_error(largest: Values, error: Values, divergence: Values) -> np.ndarray:
    """Return the error of `chaotic_dimension` that an error of the largest exponent makes, (...)."""
    return np.asarray(error * np.abs(divergence) / (largest - divergence) ** 2)
