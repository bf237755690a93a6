"""The catalogue of models: one system per file, loaded when asked for."""

from __future__ import annotations

from importlib import import_module

from quavsweep.errors import ModelError
from quavsweep.models.model import Example, Model, Relation, Section
from quavsweep.models.quantity import Observable, Parameter, State

NAMES = (
    "bldc",
    "chen",
    "chua",
    "duffing",
    "jerk",
    "linear",
    "lorenz",
    "pmsm",
    "quadrotor",
    "quadrotor_attitude",
    "quadrotor_yaw",
    "rossler",
    "stuart_landau",
    "torus",
)

POSSIBLE = f"the catalogue has {', '.join(NAMES)}; --model FILE brings another"

__all__ = [
    "NAMES",
    "POSSIBLE",
    "Example",
    "Model",
    "Observable",
    "Parameter",
    "Relation",
    "Section",
    "State",
    "load_model",
]


def load_model(name: str) -> Model:
    """Return the catalogue's model of that name.

    Raises
    ------
    ModelError
        If the catalogue has no such model.
    """
    if name not in NAMES:
        raise ModelError(f"there is no model {name}", possible=POSSIBLE)
    model = import_module(f"quavsweep.models.{name}").MODEL
    assert isinstance(model, Model)
    return model
