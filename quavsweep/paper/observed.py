"""Observables along the orbits that a sweep has recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from quavsweep.kernels.observe import observe
from quavsweep.result import Result


def observed(result: Result, names: Sequence[str], part: slice = slice(None)) -> np.ndarray:
    """Return observables along the recorded orbits of cells.

    Parameters
    ----------
    result : Result
        Of a sweep with axes and the measure `orbit`.
    names : sequence of str
    part : slice
        Of the first axis; no more of the file is read.

    Returns
    -------
    (axes..., times, len(names)) float64
    """
    u = result.part("orbit", (part,))
    values: dict[str, float | np.ndarray] = dict(result.sweep.parameters)
    for i, axis in enumerate(result.sweep.grid.axes):
        chosen = range(len(axis))[part] if i == 0 else range(len(axis))
        for name in set(axis.at(0)) & set(result.sweep.model.parameter_names):
            shape = [1] * (u.ndim - 1)
            shape[i] = len(chosen)
            values[name] = np.array([axis.at(k)[name] for k in chosen]).reshape(shape)
    return observe(result.sweep.model, names, u, values)
