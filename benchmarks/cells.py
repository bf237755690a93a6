"""The cells that are advanced: their model, parameters and initial states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from quavsweep.kernels.layout import generic_frame
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.program import Program
from quavsweep.models import Model, load_model


@dataclass(frozen=True)
class Cells:
    """Cells of a model.

    Parameters
    ----------
    model : Model
    parameters : mapping
        From every parameter's name to its values, (n,).
    u : (n, D) float64
        Initial states.
    """

    model: Model
    parameters: Mapping[str, np.ndarray]
    u: np.ndarray

    def __len__(self) -> int:
        return len(self.u)

    @property
    def program(self) -> Program:
        """The model's program."""
        return make_program(self.model)

    def coefficients(self, scale: float) -> np.ndarray:
        """Return the program's coefficients for a unit of time, (C, n)."""
        return self.program.coefficient_values(list(self.parameters.values()), scale)

    def frame(self, vectors: int) -> np.ndarray:
        """Return generic orthonormal tangent vectors, (n, K, D)."""
        dimension = self.u.shape[1]
        return np.broadcast_to(generic_frame(dimension, vectors), (len(self), vectors, dimension))


def make_cells(model: Model, varied: Mapping[str, np.ndarray], u: np.ndarray) -> Cells:
    """Return cells with the model's defaults but for the parameters that vary."""
    n = len(u)
    values = {name: np.asarray(varied.get(name, np.full(n, value))) for name, value in model.defaults.items()}
    return Cells(model, values, u)


def yaw_cells(n: int = 256) -> Cells:
    """Return cells of the yaw system across the map; 256 fit the first two levels of cache with room to spare."""
    u = np.random.default_rng(0).uniform(-1.0, 1.0, (n, 3))
    return make_cells(load_model("quadrotor_yaw"), {"Omega1": np.linspace(50.0, 500.0, n)}, u)


def lorenz_cells(n: int = 256) -> Cells:
    """Return chaotic cells of the Lorenz system, all from one start."""
    start = np.broadcast_to([1.0, 1.0, 20.0], (n, 3))
    return make_cells(load_model("lorenz"), {"rho": np.linspace(28.0, 40.0, n)}, start)
