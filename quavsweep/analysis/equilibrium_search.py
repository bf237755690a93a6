"""All equilibria of a model at given parameters, with eigenvalues and types."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from quavsweep.analysis.equilibrium import eigensystem, newton, norm, vector_field
from quavsweep.analysis.equilibrium_type import type_name
from quavsweep.analysis.interval_newton import enclose_equilibria
from quavsweep.errors import ConfigError
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.program import Program
from quavsweep.models import Model, load_model

BUDGET = 20_000  # boxes per system of at most FEW states
FEW, BUDGET_OF_MANY = 4, 1_000
STARTS, STEPS = 500, 40  # of Newton's method where the boxes do not suffice
SAME = 1e-7  # distance against 1 + |u| up to which two states are one equilibrium
ROUNDING = 1e-15  # a component below this share of 1 + |u| is zero
SEED = 0


@dataclass(frozen=True)
class Equilibria:
    """Equilibria of one system.

    Parameters
    ----------
    state_names : tuple of str, length D
    states : (n, D) float64
        In the model's units, angles within one turn, sorted by their components.
    eigenvalues : (n, D) complex128
        Largest real part first [1/time].
    types : tuple of str, length n
        Such as `saddle index 1` or `stable node-focus`.
    complete : bool
        Whether it is proved, by interval arithmetic, that the box holds no others.
    box : (D, 2) float64
        Where they were looked for.
    """

    state_names: tuple[str, ...]
    states: np.ndarray
    eigenvalues: np.ndarray
    types: tuple[str, ...]
    complete: bool
    box: np.ndarray

    def __len__(self) -> int:
        return len(self.types)


def find_equilibria(
    model: Model | str,
    parameters: Mapping[str, float] | None = None,
    box: Mapping[str, tuple[float, float]] | None = None,
) -> Equilibria:
    """Return all real equilibria of an autonomous model.

    Parameters
    ----------
    model : Model or str
        A model or the name of one of the catalogue.
    parameters : mapping, optional
        What differs from the model's defaults.
    box : mapping, optional
        From a state to the interval in which to look; by default up to the bound beyond which the model counts as
        diverged, and one turn of an angle.

    Returns
    -------
    Equilibria
        If `complete` is False, some may be missing: an equilibrium whose Jacobian is singular, as at a bifurcation,
        cannot be closed in, and boxes in many dimensions are too many. Newton's method from many starts adds to
        those that are proved then.

    Raises
    ------
    ConfigError
        If the model is forced, or there is no such parameter or state.

    Examples
    --------
    >>> find_equilibria("lorenz", {"rho": 0.5}).types
    ('stable node',)
    """
    model = load_model(model) if isinstance(model, str) else model
    program = autonomous_program(model)
    values = parameter_values(model, parameters or {})
    coefficients = program.coefficient_values([np.array([values[name]]) for name in model.parameter_names])
    return all_equilibria(model, program, coefficients, search_box(model, box or {}))[0]


def autonomous_program(model: Model) -> Program:
    """Return the program of a model that does not depend on the time.

    Raises
    ------
    ConfigError
        If it does.
    """
    if model.forcing_period is not None:
        what = "a forced system has no equilibria: its right-hand side depends on the time"
        raise ConfigError(what, model.name, "cycles of the forcing's period take their place")
    return make_program(model)


def parameter_values(model: Model, parameters: Mapping[str, float]) -> dict[str, float]:
    """Return all parameters of a model by name.

    Raises
    ------
    ConfigError
        If it has no such parameter.
    """
    for name in parameters:
        if name not in model.parameter_names:
            possible = f"it has {', '.join(model.parameter_names)}"
            raise ConfigError(f"{model.name} has no parameter {name}", possible=possible)
    return {name: float(value) for name, value in {**model.defaults, **parameters}.items()}


def search_box(model: Model, box: Mapping[str, tuple[float, float]]) -> np.ndarray:
    """Return where to look for equilibria, (D, 2) float64.

    Raises
    ------
    ConfigError
        If there is no such state, or an interval is empty.
    """
    for name, (low, high) in box.items():
        if name not in model.state_names:
            possible = f"it has {', '.join(model.state_names)}"
            raise ConfigError(f"{model.name} has no state {name}", possible=possible)
        if not -np.inf < low < high < np.inf:
            raise ConfigError(f"{name} from {low:g} to {high:g} is no interval", possible="two ascending numbers")
    default = [(0.0, s.circle) if s.circle else (-model.bound, model.bound) for s in model.states]
    return np.array([box.get(name, sides) for name, sides in zip(model.state_names, default, strict=True)], dtype=float)


def all_equilibria(model: Model, program: Program, coefficients: np.ndarray, box: np.ndarray) -> list[Equilibria]:
    """Return the equilibria of m systems, searched together.

    Parameters
    ----------
    coefficients : (C, m) float64
    box : (D, 2) float64
    """
    budget = BUDGET if program.dimension <= FEW else BUDGET_OF_MANY
    zeros = enclose_equilibria(program, coefficients, box[:, 0], box[:, 1], budget)
    found = []
    for k in range(coefficients.shape[1]):
        states = _tidy(model, zeros.states[zeros.system == k])
        left = zeros.open_states[zeros.open_system == k]
        if len(left):
            states = _with_others(model, program, coefficients[:, k : k + 1], box, states, left)
        inside = ((states >= box[:, 0] - SAME) & (states <= box[:, 1] + SAME)).all(axis=1)
        found.append(_described(model, program, coefficients[:, k : k + 1], box, states[inside], not len(left)))
    return found


def _described(
    model: Model, program: Program, coefficients: np.ndarray, box: np.ndarray, states: np.ndarray, complete: bool
) -> Equilibria:
    """Return equilibria with their eigenvalues and types."""
    states = states[np.lexsort(states.T[::-1])]
    if not len(states):
        return Equilibria(model.state_names, states, np.empty(states.shape, dtype=complex), (), complete, box)
    jacobian = vector_field(program, states, np.repeat(coefficients, len(states), axis=1))[1]
    values = eigensystem(jacobian)[0]
    return Equilibria(model.state_names, states, values, tuple(map(type_name, values)), complete, box)


def _with_others(
    model: Model, program: Program, coefficients: np.ndarray, box: np.ndarray, states: np.ndarray, left: np.ndarray
) -> np.ndarray:
    """Return equilibria with those that Newton's method finds from open boxes, and from everywhere."""
    random = np.random.default_rng(SEED)
    low, high = np.arcsinh(box).T
    anywhere = np.sinh(random.uniform(low, high, (STARTS, program.dimension)))
    nearby = left[:: max(1, len(left) // STARTS)]
    u = np.concatenate([nearby, anywhere])
    c = np.repeat(coefficients, len(u), axis=1)
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            found, reached = newton(program, u, c)
            u = np.where(np.isfinite(reached), reached, u)
    reached = _tidy(model, u[found & np.isfinite(u).all(axis=1)])
    return _distinct(model, [*states, *reached])


def _tidy(model: Model, states: np.ndarray) -> np.ndarray:
    """Return states with angles within one turn and without rounding beside zero, each once."""
    tiny = np.abs(states) <= ROUNDING * (1.0 + norm(states))[:, None]
    return _distinct(model, list(model.wrap(np.where(tiny, 0.0, states))))


def _distinct(model: Model, states: Sequence[np.ndarray]) -> np.ndarray:
    """Return states without those that are near an earlier one, (n, D)."""
    kept = np.empty((0, len(model.states)))
    for u in states:
        if not (norm(model.difference(kept, u[None])) <= SAME * (1.0 + norm(kept))).any():
            kept = np.concatenate([kept, u[None]])
    return kept
