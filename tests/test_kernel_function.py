"""Printed kernels of models with functions and kinks: against naive twins, to the bit across lanes, as machine code."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from benchmarks.assembly import kinds, printed_loop
from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.derive import derive
from quavsweep.kernels.formula import HALF_PI
from quavsweep.kernels.layout import Layout, generic_frame
from quavsweep.kernels.method import RK4
from quavsweep.kernels.printer import print_kernel, step_operations
from quavsweep.kernels.program import Program
from quavsweep.models import Model, load_model
from tests import twin
from tests.function_models import CHUA, MODELS, PENDULUM, RECTIFIER, STAGES

EPS = np.finfo(float).eps
DT = 0.01


def _values(program: Program, u: np.ndarray, p: np.ndarray) -> dict[str, float]:
    return dict(zip((*program.states, *program.parameters), (*u, *p), strict=True))


def _cells(model: Model, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return states (n, D) and parameters (P, n)."""
    rng = np.random.default_rng(17)
    u = rng.uniform(-2, 2, (64, len(model.states)))
    return u[:n], np.outer(list(model.defaults.values()), rng.uniform(0.9, 1.1, 64))[:, :n]


def _advanced(model: Model, vectors: int, n: int, blocks: int, block: int, lanes: int = 16) -> np.ndarray:
    """Return rows of state, frame and stretching factors of n cells, (n, rows)."""
    u, parameters = _cells(model, n)
    program, dimension = derive(model), u.shape[1]
    layout = Layout(dimension, vectors, len(program.coefficients), lanes)
    frame = np.broadcast_to(generic_frame(dimension, vectors), (n, vectors, dimension))
    table = layout.pack(u, frame, program.coefficient_values(list(parameters), RK4.time_unit(DT)))
    make_advance(program, RK4, layout)(table.reshape(-1), 0, table.shape[0], blocks, block)
    frames = layout.frame(table, n).reshape(n, -1)
    return np.concatenate([layout.state(table, n), frames, layout.take_stretch(table, n)], axis=1)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_program_computes_what_the_function_says(model: Model) -> None:
    program = derive(model)
    states, parameters = _cells(model, 50)
    for u, p in zip(states, parameters.T, strict=True):
        expected = np.array(model.rhs(*u, *p))
        values = np.array(program.evaluate(program.rhs, _values(program, u, p)))
        assert np.abs(values - expected).max() <= 16 * EPS * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_derivatives_equal_differences(model: Model) -> None:
    """Central differences, of the function for the Jacobian and of the Jacobian for the Hessian."""
    program, h = derive(model), 1e-6
    states, parameters = _cells(model, 20)
    dimension = states.shape[1]
    flat = [entry for row in program.jacobian for entry in row]
    for u, p in zip(states, parameters.T, strict=True):
        for j, shift in enumerate(h * np.eye(dimension)):
            column = np.subtract(model.rhs(*(u + shift), *p), model.rhs(*(u - shift), *p)) / (2 * h)
            derived = program.evaluate([row[j] for row in program.jacobian], _values(program, u, p))
            np.testing.assert_allclose(np.array(derived, dtype=float), column, rtol=1e-7, atol=1e-7)
            ends = [program.evaluate(flat, _values(program, u + sign * shift, p)) for sign in (1, -1)]
            change = np.subtract(*np.array(ends, dtype=float)).reshape(dimension, dimension) / (2 * h)
            entries = [row[j] for matrix in program.hessian for row in matrix]
            second = program.evaluate(entries, _values(program, u, p))
            np.testing.assert_allclose(np.array(second, dtype=float), change.ravel(), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("model", [PENDULUM, CHUA, RECTIFIER], ids=lambda model: model.name)
def test_a_step_equals_the_naive_twin(model: Model) -> None:
    n, dimension = 40, len(model.states)
    u, parameters = _cells(model, n)
    rows = _advanced(model, 1, n, 1, 1)
    for cell in range(n):
        frame = [list(generic_frame(dimension, 1)[0])]
        state, (vector,) = twin.step(model, list(u[cell]), frame, list(parameters[:, cell]), DT)
        assert np.abs(rows[cell, :dimension] - state).max() <= 4 * EPS * np.abs(state).max()
        first = rows[cell, dimension : 2 * dimension] * rows[cell, 2 * dimension]
        assert np.abs(first - vector).max() <= 4 * EPS * np.abs(vector).max()


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_20_steps_equal_the_naive_twin(model: Model) -> None:
    n, dimension = 5, len(model.states)
    u, parameters = _cells(model, n)
    rows = _advanced(model, 0, n, 2, 10)
    for cell in range(n):
        state = list(u[cell])
        for _ in range(20):
            state, _ = twin.step(model, state, [], list(parameters[:, cell]), DT)
        assert np.abs(rows[cell, :dimension] - state).max() <= 1e-13 * np.abs(state).max()


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_bits_do_not_depend_on_lanes(model: Model) -> None:
    expected = _advanced(model, 1, 64, 2, 10)
    np.testing.assert_array_equal(_advanced(model, 1, 64, 2, 10, lanes=24), expected)
    np.testing.assert_array_equal(_advanced(model, 1, 5, 2, 10), expected[:5])


def test_both_forms_of_a_step_compute_the_same() -> None:
    u, parameters = _cells(PENDULUM, 16)
    program = derive(PENDULUM)
    joint = Layout(2, 2, len(program.coefficients))
    coefficients = program.coefficient_values(list(parameters), RK4.time_unit(DT))
    frame = np.broadcast_to(generic_frame(2, 2), (16, 2, 2))
    tables = []
    for layout in (joint, replace(joint, scratch=RK4.stages * 4)):
        table = layout.pack(u, frame, coefficients)
        make_advance(program, RK4, layout)(table.reshape(-1), 0, 1, 2, 10)
        tables.append((layout.state(table, 16), layout.frame(table, 16)))
    np.testing.assert_array_equal(tables[0][0], tables[1][0])
    np.testing.assert_allclose(tables[0][1], tables[1][1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("vectors", [0, 2])
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_step_is_vectorised(model: Model, vectors: int) -> None:
    """And its operations are about those that the cost model counts."""
    program = derive(model)
    layout = Layout(len(model.states), vectors, len(program.coefficients))
    body = printed_loop(print_kernel(program, RK4, layout))
    counts = kinds(body)
    assert counts["pd"] > 40
    assert not counts["sd"]
    assert not [name for name, _ in body if name.startswith(("call", "vcvt", "vpextr", "vpinsr"))]
    instructions = sum(name.startswith("v") and not name.startswith(("vmov", "vbroadcast")) for name, _ in body)
    assert 0.6 <= step_operations(program, RK4, layout) / instructions <= 1.6


def test_sine_and_cosine_share_the_reduction_of_their_argument() -> None:
    program = derive(PENDULUM)
    source = print_kernel(program, RK4, Layout(2, 2, len(program.coefficients)))
    assert source.count(repr(HALF_PI[2])) == RK4.stages


def test_kernels_without_functions_have_no_instructions_of_their_own() -> None:
    program = derive(load_model("lorenz"))
    source = print_kernel(program, RK4, Layout(3, 3, len(program.coefficients)))
    assert source.count("@intrinsic") == 1
    assert "from math import sqrt\n" in source


def test_a_pendulum_swings_with_the_period_of_the_elliptic_integral() -> None:
    start, steps = 2.5, 800
    period = 4 * ellipk(np.sin(start / 2) ** 2) / 2.0
    program = derive(PENDULUM)
    layout = Layout(2, 0, len(program.coefficients))
    free = [np.array([value]) for value in (4.0, 0.0, 0.0)]
    lanes = layout.pack(
        np.array([[start, 0.0]]), np.empty((1, 0, 2)), program.coefficient_values(free, RK4.time_unit(period / steps))
    )
    make_advance(program, RK4, layout)(lanes.reshape(-1), 0, 1, 1, steps)
    np.testing.assert_allclose(layout.state(lanes, 1)[0], [start, 0.0], atol=1e-7)


def test_chuas_circuit_follows_an_independent_integrator() -> None:
    p = list(CHUA.defaults.values())
    exact = solve_ivp(lambda t, u: CHUA.rhs(*u, *p), (0, 5), (0.1, 0.2, -0.3), "DOP853", rtol=1e-12, atol=1e-12).y[
        :, -1
    ]
    program = derive(CHUA)
    layout = Layout(3, 0, len(program.coefficients))
    coefficients = program.coefficient_values([np.array([value]) for value in p], RK4.time_unit(0.001))
    lanes = layout.pack(np.array([[0.1, 0.2, -0.3]]), np.empty((1, 0, 3)), coefficients)
    make_advance(program, RK4, layout)(lanes.reshape(-1), 0, 1, 1, 5000)
    np.testing.assert_allclose(layout.state(lanes, 1)[0], exact, atol=1e-6)


@pytest.mark.parametrize("model", [PENDULUM, CHUA, RECTIFIER, STAGES], ids=lambda model: model.name)
def test_a_diverged_cell_does_not_look_fine(model: Model) -> None:
    program, dimension = derive(model), len(model.states)
    layout = Layout(dimension, 0, len(program.coefficients))
    coefficients = program.coefficient_values([np.full(2, p) for p in model.defaults.values()], RK4.time_unit(DT))
    u = np.array([[np.nan] * dimension, [np.inf] * dimension])
    lanes = layout.pack(u, np.empty((2, 0, dimension)), coefficients)
    make_advance(program, RK4, layout)(lanes.reshape(-1), 0, 1, 1, 2)
    assert not np.isfinite(layout.state(lanes, 2)).all(axis=1).any()
