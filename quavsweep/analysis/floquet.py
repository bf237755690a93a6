"""Floquet multipliers and exponents of closed orbits, also those that are lost in the rounding of the derivative."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quavsweep.analysis.equilibrium import eigensystem
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.shooting import METHOD, Closed
from quavsweep.kernels.layout import generic_frame

LOST = 1e-11  # a multiplier below this share of the derivative's norm is rounding
SMALL = 1e-4  # one below this share is not exact, and better known otherwise if it is real and stands alone
APART = 1e3  # ratio to the multipliers beside it at which it stands alone
SHRINKING = 10.0  # ln of the growth of volume in a part of the period, so that nothing is lost in one
ROUNDS = 4  # periods until frames lie along the cycle's own directions; where any are lost, these are far apart


def floquet(flow: Flow, closed: Closed, parameters: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return Floquet multipliers, (n, D) complex128, largest size first, and exponents, (n, D), largest first.

    A multiplier that is lost in the rounding of the derivative, or small and alone, is taken from the growth of
    volume, which all of them make together; if there are several, from the stretching of an orthonormal frame along
    the cycle, which tells their sizes only. No exponent is set to zero. In forced systems several that are lost are
    NaN.
    """
    values, _ = eigensystem(np.where(closed.found[:, None, None], closed.derivative, 0.0))
    order = np.lexsort((-values.imag, -np.abs(values)), axis=-1)
    values = np.take_along_axis(values, order, axis=-1)
    with np.errstate(all="ignore"):
        growth = np.log(np.abs(values))
        lost = _lost(values, np.abs(closed.derivative).max(axis=(1, 2)), flow.program.forced)
        several = np.flatnonzero(closed.found & (lost.sum(axis=1) > 1))
        if several.size and not flow.program.forced:
            seen = frame_growth(flow, closed.take(several), [p[several] for p in parameters])
            growth[several] = np.where(lost[several], seen, growth[several])
        rest = closed.volume - np.where(lost, 0.0, growth).sum(axis=1)
        growth = np.where(lost & (lost.sum(axis=1) == 1)[:, None], rest[:, None], growth)
        if flow.program.forced:  # parts of a period begin at other phases than a run
            growth[several] = np.where(lost[several], np.nan, growth[several])
        sign = np.sign(np.where(lost, 1.0, values).prod(axis=1).real)  # a flow keeps the orientation
        sign = np.where(lost.sum(axis=1) == 1, sign, 1.0)
        values = np.where(lost, sign[:, None] * np.exp(growth), values)
        exponents = growth / closed.period[:, None]
    values[~closed.found], exponents[~closed.found] = complex(np.nan, np.nan), np.nan
    return values, exponents


def _lost(values: np.ndarray, norm: np.ndarray, forced: bool) -> np.ndarray:
    """Return which multipliers are better not taken from the derivative, (n, D) bool."""
    size, edge = np.abs(values), np.full((len(values), 1), np.inf)
    ratio = size[:, :-1] / size[:, 1:]
    alone = (np.concatenate([edge, ratio], axis=1) > APART) & (np.concatenate([ratio, edge], axis=1) > APART)
    small = (size <= SMALL * norm[:, None]) & (values.imag == 0) & alone
    lost = (size <= LOST * norm[:, None]) | small
    if forced:
        lost &= (size <= LOST * norm[:, None]) | (lost.sum(axis=1) == 1)[:, None]
    return np.asarray(lost)


def frame_growth(flow: Flow, closed: Closed, parameters: Sequence[np.ndarray]) -> np.ndarray:
    """Return ln of the stretching of an orthonormal frame over the last of some periods, (n, D), largest first.

    The derivative over a period is taken apart into factors along the orbit, and the frame is orthonormalised after
    each, so that no direction drowns in a larger one. The system is autonomous.
    """
    n, dimension = closed.point.shape
    growth = np.full((n, dimension), np.nan)
    parts = np.maximum(np.ceil(np.abs(closed.volume) / SHRINKING), 1).astype(int)
    for count in np.unique(parts):
        cells = np.flatnonzero(parts == count)
        some, own = closed.take(cells), [p[cells] for p in parameters]
        time, steps = some.period / count, some.steps // count + 1
        frame = np.broadcast_to(generic_frame(dimension, dimension).T, (cells.size, dimension, dimension))
        for _ in range(ROUNDS):
            point, total = some.point, np.zeros((cells.size, dimension))
            for _ in range(count):
                point, factor, _ = flow.tangent(METHOD, point, own, time, steps)
                frame, triangle = np.linalg.qr(np.matmul(factor, frame))
                total += np.log(np.abs(triangle.diagonal(axis1=1, axis2=2)))
        growth[cells] = -np.sort(-total, axis=1)
    return growth
