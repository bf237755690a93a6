"""Observables of a model at given states, computed by their program: the same bits on every machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from quavsweep.kernels.lookup import make_observables
from quavsweep.kernels.program import TIME
from quavsweep.models import Model


def observe(model: Model, names: Sequence[str], u: Any, parameters: Mapping[str, Any], t: Any = 0.0) -> np.ndarray:
    """Return observables of states.

    Parameters
    ----------
    model : Model
    names : sequence of str
        The observables.
    u : (..., D) float64
        States in the model's order and units.
    parameters : mapping
        From every parameter's name to a number, or to an array that broadcasts against (...).
    t : float or array
        Time at the states, which only observables of forced systems may depend on.

    Returns
    -------
    (..., len(names)) float64
        In the observables' units; NaN where a state is.

    Raises
    ------
    KeyError
        If there is no such observable.
    """
    program, index = make_observables(model), {name: i for i, name in enumerate(model.observable_names)}
    u = np.asarray(u, dtype=np.float64)
    values = {f"u_{name}": u[..., i] for i, name in enumerate(model.state_names)}
    values |= {f"p_{name}": np.asarray(parameters[name], dtype=np.float64) for name in model.parameter_names}
    shape = np.broadcast_shapes(*(np.shape(value) for value in values.values()), np.shape(t))
    with np.errstate(all="ignore"):
        found = program.evaluate([program.rhs[index[name]] for name in names], {**values, TIME: np.asarray(t)})
    columns = [np.broadcast_to(np.asarray(value, dtype=np.float64), shape) for value in found]
    return np.stack(columns, axis=-1) if columns else np.empty((*shape, 0))
