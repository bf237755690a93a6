"""One cell of a sweep on its own, to the bit the map's: its result, its orbit, and how its exponents converge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quavsweep.config import Sweep


@dataclass(frozen=True)
class Point:
    """What a single cell does.

    Parameters
    ----------
    sweep : Sweep
        Of this cell alone; it has no axes.
    values : dict of arrays
        The result's variables, without dimensions for axes: `region` (), `lyapunov` (K,), `final_state` (D,) ...
    time : (n,) float64
        Times of the orbit, evenly spaced from 0 to where the integration ended, in the model's time.
    orbit : (n, D) float64
        States at these times.
    averaged_until : (m,) float64
        Times until which the exponents below are averaged; the average begins after the transient, or at 0 where
        the cell ended within it.
    exponents, errors : (m, K) float64
        Averages until these times, and their standard errors (inf where there are too few batches).
    """

    sweep: Sweep
    values: dict[str, np.ndarray]
    time: np.ndarray
    orbit: np.ndarray
    averaged_until: np.ndarray
    exponents: np.ndarray
    errors: np.ndarray
