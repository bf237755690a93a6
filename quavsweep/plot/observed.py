"""Observables of stored states: computed when they are drawn, from the parameters of each cell."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quavsweep.kernels.observe import observe

if TYPE_CHECKING:
    from quavsweep.result import Result

VARIABLES = ("orbit", "samples", "final_state", "equilibrium")  # of states, from which observables are computed


def observed(result: Result, variable: str, name: str) -> np.ndarray:
    """Return an observable along a stored variable of states, (axes..., ...) float64; NaN where the states are."""
    sweep, u = result.sweep, result[variable]
    fixed = {n: np.asarray(value) for n, value in sweep.parameters.items()}
    varied = sweep.grid.coordinates(0, sweep.grid.size)
    inner = (1,) * (u.ndim - 1 - len(sweep.grid.shape))
    of_cells = {
        n: values.reshape(*sweep.grid.shape, *inner) for n, values in varied.items() if n in sweep.model.defaults
    }
    time: float | np.ndarray = 0.0
    if sweep.model.forcing_period is not None:
        time = {"orbit": result["time"], "samples": result["sample_time"]}.get(variable, result["time_used"])
    return observe(sweep.model, [name], u, {**fixed, **of_cells}, time)[..., 0]
