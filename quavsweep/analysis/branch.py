"""Branches of equilibria along a parameter, and the test functions whose zeros are bifurcations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from quavsweep.analysis.continuation import Window, corrected, follow
from quavsweep.analysis.equilibrium import vector_field
from quavsweep.kernels.program import Program
from quavsweep.models import Model

NUDGE = 1e-5  # of the parameter's range, by which derivatives in it are taken
NUDGE_STATE = 1e-4  # of 1 + |u|, by which third derivatives are taken
TYPICAL = 0.1  # of 1 + |u|, a distance over which functions change
NEAR = 1e-6  # distance to a branch, in its units, at which a point is on it


def zero_test(eigenvalues: np.ndarray) -> float:
    """Return the product of all eigenvalues over their sizes' largest: zero where a real one is."""
    largest = float(np.abs(eigenvalues).max())
    return float(np.prod(eigenvalues / largest).real) if largest else 0.0


def hopf_test(eigenvalues: np.ndarray) -> float:
    """Return the product of all sums of two eigenvalues over their sizes' largest: zero where a pair is imaginary."""
    largest = float(np.abs(eigenvalues).max())
    i, j = np.triu_indices(len(eigenvalues), 1)
    return float(np.prod((eigenvalues[i] + eigenvalues[j]) / largest).real) if largest else 0.0


class Branches:
    """Equilibria of a model along one parameter, as curves.

    A point of a curve is x = (u / scale, parameter from 0 to 1 over its range), so that steps suit both.

    Parameters
    ----------
    values : mapping
        All parameters by name.
    parameter : str
        Which of them varies.
    reach : (float, float)
        From where to where.
    box : (D, 2) float64
        Where states are followed; angles go on beyond a turn.
    """

    def __init__(
        self,
        model: Model,
        program: Program,
        values: Mapping[str, float],
        parameter: str,
        reach: tuple[float, float],
        box: np.ndarray,
    ) -> None:
        self.model, self.program = model, program
        self.values, self.parameter = values, parameter
        self.low, self.width = reach[0], reach[1] - reach[0]
        self.scale = np.ones(program.dimension)
        free = np.array([bool(state.circle) for state in model.states])
        self._box = np.where(free, -np.inf, box[:, 0]), np.where(free, np.inf, box[:, 1])

    def point(self, x: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the state and the parameter of a point."""
        return x[:-1] * self.scale, float(self.low + x[-1] * self.width)

    def at(self, u: np.ndarray, value: float) -> np.ndarray:
        """Return the point of a state and a value of the parameter."""
        return np.append(u / self.scale, (value - self.low) / self.width)

    def through(self, seeds: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the branches through equilibria and values of the parameter (D + 1,), each once, (n, D + 1)."""
        if len(seeds):
            self.scale = np.maximum(1.0, np.abs(np.array(seeds)[:, :-1]).max(axis=0))
        branches: list[np.ndarray] = []
        for seed in seeds:
            x = self.at(seed[:-1], seed[-1])
            if not any(self._passes(branch, x) for branch in branches):
                branches.append(follow(self.system, x, self._window()))
        return branches

    def _window(self) -> Window:
        low, high = self._box
        return Window(np.append(low / self.scale, 0.0), np.append(high / self.scale, 1.0))

    def _passes(self, branch: np.ndarray, x: np.ndarray) -> bool:
        """Return whether a branch passes a point: where it has the parameter's value, Newton finds the same state."""
        mu, along = branch[:, -1], np.eye(len(x))[-1]
        for k in np.flatnonzero((mu[:-1] - x[-1]) * (mu[1:] - x[-1]) <= 0):
            span = mu[k + 1] - mu[k]
            share = (x[-1] - mu[k]) / span if span else 0.0
            guess = branch[k] + share * (branch[k + 1] - branch[k])
            guess[-1] = x[-1]
            found = corrected(self.system, guess, along)
            found = guess if found is None else found
            apart = self.model.difference((found[:-1] * self.scale)[None], (x[:-1] * self.scale)[None])[0]
            if np.linalg.norm(apart / self.scale) <= NEAR:
                return True
        return False

    def system(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives (D,) and their own in the state and the parameter (D, D + 1), in units of the curve."""
        u, value = self.point(x)
        du, jacobian = self._fields(np.tile(u, (3, 1)), value + self.width * NUDGE * np.array([0.0, 1.0, -1.0]))
        drift = (du[1] - du[2]) / (2.0 * NUDGE)
        return du[0], np.column_stack([jacobian[0] * self.scale, drift])

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Return the Jacobian matrix at a point, (D, D) [1/time]."""
        u, value = self.point(x)
        return np.asarray(self._fields(u[None], np.array([value]))[1][0])

    def spectrum(self, x: np.ndarray) -> np.ndarray:
        """Return the eigenvalues at a point, (D,) complex128 [1/time]."""
        return np.linalg.eigvals(self.jacobian(x)).astype(complex)

    def parameter_derivative(self, x: np.ndarray) -> np.ndarray:
        """Return the derivative of the derivatives in the parameter, (D,)."""
        return np.asarray(self.system(x)[1][:, -1] / self.width)

    def typical_drift(self, x: np.ndarray, v: np.ndarray) -> float:
        """Return the size of the derivative in the parameter at a state some way along v, by which zero is told."""
        u, value = self.point(x)
        beside = self.at(u + TYPICAL * (1.0 + np.linalg.norm(u)) * v, value)
        return float(np.linalg.norm(self.parameter_derivative(beside)))

    def higher_derivatives(self, x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the second derivatives (D, D, D), and the third ones taken three times along v, (D,)."""
        u, value = self.point(x)
        nudge = NUDGE_STATE * (1.0 + np.linalg.norm(u))
        states = u + nudge * np.array([0.0, 1.0, -1.0])[:, None] * v
        entries = [entry for matrix in self.program.hessian for row in matrix for entry in row]
        names = self.program.names(np.ascontiguousarray(states.T), self._coefficients(np.full(3, value)))
        table = np.array([np.broadcast_to(entry, (3,)) for entry in self.program.evaluate(entries, names)])
        size = self.program.dimension
        second = table.T.reshape(3, size, size, size)
        third = np.einsum("ijk,j,k->i", second[1] - second[2], v, v) / (2.0 * nudge)
        return second[0], third

    def _fields(self, u: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return vector_field(self.program, u, self._coefficients(value))

    def _coefficients(self, value: np.ndarray) -> np.ndarray:
        """Return the coefficients at some values of the parameter, (C, n)."""
        given: dict[str, Any] = {**self.values, self.parameter: value}
        columns = [np.broadcast_to(given[name], value.shape) for name in self.model.parameter_names]
        return self.program.coefficient_values(columns)
