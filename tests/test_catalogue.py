"""The catalogue: derived Jacobians and Hessians, symmetries, closed forms and published values of every model."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.program import TIME, Program
from quavsweep.models import NAMES, Model, load_model

T = 0.7  # time at which forced systems are looked at
TINY = 1e-30  # step of complex steps


def _point(model: Model, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a state and parameters."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-3, 3, len(model.states)), np.array([*model.defaults.values()]) * rng.uniform(
        0.5, 2.0, len(model.parameters)
    )


def _values(program: Program, u: np.ndarray, p: np.ndarray) -> dict[str, object]:
    return {**dict(zip((*program.states, *program.parameters), (*u, *p), strict=True)), TIME: T}


def _columns(model: Model, u: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the Jacobian by complex steps."""
    columns = []
    for j in range(u.size):
        moved = u.astype(complex)
        moved[j] += TINY * 1j
        columns.append([complex(f).imag / TINY for f in model.field(moved, p, T)])
    return np.array(columns).T


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_equals_complex_steps(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    for seed in range(20):
        u, p = _point(model, seed)
        expected, values = _columns(model, u, p), _values(program, u, p)
        derived = np.array([program.evaluate(row, values) for row in program.jacobian], dtype=float)
        assert np.abs(derived - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_hessian_equals_differences_of_the_jacobian(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    u, p = _point(model, 1)
    size, h = u.size, 1e-5
    for k in range(size):
        shift = h * np.eye(size)[k]
        expected = (_columns(model, u + shift, p) - _columns(model, u - shift, p)) / (2 * h)
        entries = [matrix[k] for row in program.hessian for matrix in row]
        derived = np.array(program.evaluate(entries, _values(program, u, p)), dtype=float).reshape(size, size)
        assert np.abs(derived - expected).max() <= 1e-8 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", NAMES)
def test_program_computes_what_the_function_says(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    for seed in range(5):
        u, p = _point(model, seed)
        expected = np.array(model.field(u, p, T))
        tolerance = 1e-13 * np.abs(expected).max()
        np.testing.assert_allclose(program.evaluate(program.rhs, _values(program, u, p)), expected, 1e-12, tolerance)


@pytest.mark.parametrize("name", NAMES)
def test_equations_have_the_declared_symmetries(name: str) -> None:
    model = load_model(name)
    u, p = _point(model, 3)
    for signs in model.symmetries:
        mirrored = np.array(model.field(signs * u, p, T))
        np.testing.assert_array_equal(mirrored, np.array(signs) * np.array(model.field(u, p, T)))
