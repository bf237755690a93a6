"""Printed kernels: against naive twins, to the bit across lanes, and as machine code."""

from __future__ import annotations

import inspect
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.assembly import kinds, printed_loop
from quavsweep.kernels.compiler import LANES, cpu_class, make_advance
from quavsweep.kernels.derive import derive
from quavsweep.kernels.layout import Layout, generic_frame
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.method import DP8, RK4, ButcherTable
from quavsweep.kernels.printer import print_kernel
from quavsweep.kernels.step import choose_layout
from quavsweep.models import Model, Parameter, State, load_model
from tests import twin

EPS = np.finfo(float).eps
NAMES = ("lorenz", "quadrotor_yaw")


def _lorenz_96(dimension: int) -> Model:
    """Return the ring of E. N. Lorenz, Predictability: a problem partly solved (1996), in any dimension."""

    def rhs(*x: Any) -> tuple[Any, ...]:
        *u, force = x
        return tuple((u[(i + 1) % dimension] - u[i - 2]) * u[i - 1] - u[i] + force for i in range(dimension))

    names = [f"x{i}" for i in range(dimension)]
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    rhs.__signature__ = inspect.Signature([inspect.Parameter(name, kind) for name in (*names, "force")])  # type: ignore[attr-defined]
    return Model("lorenz_96", rhs, tuple(State(name) for name in names), (Parameter("force", 8.0),))


def _start(model: Model, n: int, vectors: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return states of size 1, generic frames and parameters (P, n) of n cells."""
    rng = np.random.default_rng(5)
    u = rng.uniform(-1, 1, (n, len(model.states)))
    frame = np.broadcast_to(generic_frame(len(model.states), vectors), (n, vectors, len(model.states)))
    return u, frame, np.outer(list(model.defaults.values()), rng.uniform(0.9, 1.1, n))


def _advanced(
    model: str | Model,
    vectors: int,
    n: int,
    blocks: int,
    block: int,
    dt: float,
    lanes: int = 16,
    method: ButcherTable = RK4,
    split: bool = False,
) -> np.ndarray:
    """Return rows of state, frame and stretching factors of n cells, (n, rows)."""
    model = load_model(model) if isinstance(model, str) else model
    u, frame, parameters = _start(model, n, vectors)
    program = derive(model)
    layout = choose_layout(program, method, vectors, lanes)
    if split:
        layout = replace(layout, scratch=method.stages * program.dimension**2)
    table = layout.pack(u, frame, program.coefficient_values(list(parameters), method.time_unit(dt)))
    make_advance(program, method, layout)(table.reshape(-1), 0, table.shape[0], blocks, block)
    state, frames = layout.state(table, n), layout.frame(table, n)
    return np.concatenate([state, frames.reshape(n, -1), layout.take_stretch(table, n)], axis=1)


@pytest.mark.parametrize("vectors", [0, 1, 2, 3])
@pytest.mark.parametrize(("method", "ulps"), [(RK4, 4), (DP8, 64)])  # entries of DP8 are as large as 43, and cancel
@pytest.mark.parametrize("name", NAMES)
def test_a_step_equals_the_naive_twin(name: str, method: ButcherTable, ulps: int, vectors: int) -> None:
    _compare_a_step(load_model(name), method, ulps, vectors)


@pytest.mark.parametrize("dimension", [4, 7, pytest.param(12, marks=pytest.mark.slow)])
def test_a_step_of_any_dimension_equals_the_naive_twin(dimension: int) -> None:
    _compare_a_step(_lorenz_96(dimension), RK4, 8, dimension)


def _compare_a_step(model: Model, method: ButcherTable, ulps: int, vectors: int) -> None:
    n, dt, dimension = 20, 0.01, len(model.states)
    u, frame, parameters = _start(model, n, vectors)
    rows = _advanced(model, vectors, n, 1, 1, dt, method=method)
    for cell in range(n):
        p = list(parameters[:, cell])
        state, after = twin.step(model, list(u[cell]), [list(q) for q in frame[cell]], p, dt, method)
        assert np.abs(rows[cell, :dimension] - state).max() <= ulps * EPS * np.abs(state).max()
        # The kernel has orthonormalised; the first vector keeps its direction, its length is the first factor.
        if vectors:
            first = rows[cell, dimension : 2 * dimension] * rows[cell, dimension * (1 + vectors)]
            assert np.abs(first - after[0]).max() <= ulps * EPS * np.abs(after[0]).max()
            factors = twin.gram_schmidt(after)[1]
            np.testing.assert_allclose(rows[cell, -vectors:], factors, rtol=1e-13)


@pytest.mark.parametrize("vectors", [1, 3])
@pytest.mark.parametrize("name", NAMES)
def test_both_forms_of_a_step_compute_the_same(name: str, vectors: int) -> None:
    joint = _advanced(name, vectors, 32, 4, 25, 0.01)
    split = _advanced(name, vectors, 32, 4, 25, 0.01, split=True)
    np.testing.assert_array_equal(split[:, :3], joint[:, :3])
    np.testing.assert_allclose(split, joint, rtol=0, atol=1e-12)  # other products of tangent vectors are fused


def test_large_steps_are_split() -> None:
    yaw, ring = make_program(load_model("quadrotor_yaw")), derive(_lorenz_96(7))
    assert choose_layout(yaw, RK4, 3, 16).scratch == 0
    assert choose_layout(yaw, DP8, 0, 16).scratch == 0
    assert choose_layout(yaw, DP8, 3, 16).scratch == 12 * 6
    assert choose_layout(ring, RK4, 7, 16).scratch > 0


@pytest.mark.parametrize("vectors", [0, 2])
@pytest.mark.parametrize("name", NAMES)
def test_the_trace_is_integrated(name: str, vectors: int) -> None:
    """Along an orbit the integral of the trace is the sum of all exponents times the time, to the method's order."""
    model = load_model(name)
    u, frame, parameters = _start(model, 16, vectors)
    program = make_program(model)
    layout = choose_layout(program, DP8, vectors, 16, last_from_trace=True)
    table = layout.pack(u, frame, program.coefficient_values(list(parameters), DP8.time_unit(0.01)))
    make_advance(program, DP8, layout)(table.reshape(-1), 0, 1, 4, 25)
    full = _advanced(name, 3, 16, 4, 25, 0.01, method=DP8)
    np.testing.assert_array_equal(layout.state(table, 16), full[:, :3])
    growth, volume = np.zeros((1, vectors + 1, 16)), np.zeros((1, 1, 16))
    layout.add_growth(table, growth, volume)
    np.testing.assert_allclose(growth[0].sum(axis=0), np.log(full[:, -3:]).sum(axis=1), rtol=0, atol=1e-9)
    np.testing.assert_allclose(growth[0, :vectors].T, np.log(full[:, 12 : 12 + vectors]), rtol=0, atol=1e-12)
    layout.add_growth(table, growth, volume)  # nothing is taken twice
    np.testing.assert_allclose(growth[0].sum(axis=0), np.log(full[:, -3:]).sum(axis=1), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_every_vector_of_a_step_equals_the_naive_twin_to_4_ulp(name: str) -> None:
    """One vector at a time, so that Gram-Schmidt does not change its direction."""
    model = load_model(name)
    program = make_program(model)
    layout = Layout(3, 1, len(program.coefficients))
    u, _, parameters = _start(model, 16, 1)
    for k in range(3):
        frame = np.broadcast_to(generic_frame(3, 3)[k], (16, 1, 3))
        lanes = layout.pack(u, frame, program.coefficient_values(list(parameters), RK4.time_unit(0.01)))
        make_advance(program, RK4, layout)(lanes.reshape(-1), 0, 1, 1, 1)
        after = layout.frame(lanes, 16)[:, 0] * layout.take_stretch(lanes, 16)
        for cell in range(16):
            _, (expected,) = twin.step(model, list(u[cell]), [list(frame[cell, 0])], list(parameters[:, cell]), 0.01)
            assert np.abs(after[cell] - expected).max() <= 4 * EPS * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_100_steps_equal_the_naive_twin_to_1e_12(name: str) -> None:
    n, dt = 5, 0.01
    u, frame, parameters = _start(load_model(name), n, 3)
    rows = _advanced(name, 3, n, 4, 25, dt)
    for cell in range(n):
        state, growth = twin.lyapunov(
            load_model(name), list(u[cell]), [list(q) for q in frame[cell]], list(parameters[:, cell]), dt, 100, 25
        )
        assert np.abs(rows[cell, :3] - state).max() <= 1e-12 * np.abs(state).max()
        np.testing.assert_allclose(np.log(rows[cell, -3:]), growth, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_bits_do_not_depend_on_lanes_or_neighbours(name: str) -> None:
    expected = _advanced(name, 3, 96, 3, 25, 0.01, 16)
    for lanes in (24, 32, 64):
        np.testing.assert_array_equal(_advanced(name, 3, 96, 3, 25, 0.01, lanes), expected)
    u, frame, parameters = _start(load_model(name), 96, 3)
    program = make_program(load_model(name))
    layout = Layout(3, 3, len(program.coefficients))
    order = np.random.default_rng(8).permutation(96)[:37]
    table = layout.pack(
        u[order], frame[order], program.coefficient_values(list(parameters[:, order]), RK4.time_unit(0.01))
    )
    make_advance(program, RK4, layout)(table.reshape(-1), 0, table.shape[0], 3, 25)
    np.testing.assert_array_equal(layout.state(table, 37), expected[order, :3])


@pytest.mark.parametrize("name", NAMES)
def test_the_state_does_not_depend_on_the_number_of_vectors(name: str) -> None:
    expected = _advanced(name, 0, 16, 4, 25, 0.01)
    for vectors in (1, 2, 3):
        np.testing.assert_array_equal(_advanced(name, vectors, 16, 4, 25, 0.01)[:, :3], expected)


def test_the_frame_is_orthonormal_after_a_block() -> None:
    rows = _advanced("lorenz", 3, 16, 2, 25, 0.01)
    frame = rows[:, 3:12].reshape(16, 3, 3)
    # Modified Gram-Schmidt loses digits with the condition of the frame, here about 1e3 within a block.
    np.testing.assert_allclose(frame @ frame.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (16, 3, 3)), atol=1e-11)


def test_a_diverging_cell_does_not_touch_its_neighbours() -> None:
    u, frame, parameters = _start(load_model("lorenz"), 16, 3)
    program = make_program(load_model("lorenz"))
    layout = Layout(3, 3, len(program.coefficients))
    expected = _advanced("lorenz", 3, 16, 4, 25, 0.01)
    u[5] = 1e200
    table = layout.pack(u, frame, program.coefficient_values(list(parameters), RK4.time_unit(0.01)))
    make_advance(program, RK4, layout)(table.reshape(-1), 0, 1, 4, 25)
    state = layout.state(table, 16)
    assert not np.isfinite(state[5]).all()
    others = np.arange(16) != 5
    np.testing.assert_array_equal(state[others], expected[others, :3])


@pytest.mark.parametrize("vectors", [0, 2, 3])
@pytest.mark.parametrize("name", NAMES)
def test_the_step_is_vectorised(name: str, vectors: int) -> None:
    program = make_program(load_model(name))
    source = print_kernel(program, RK4, Layout(3, vectors, len(program.coefficients)))
    body = printed_loop(source)
    found = kinds(body)
    assert found["pd"] >= 0.95 * (found["pd"] + found["sd"])
    assert found["pd"] > 40
    if name == "quadrotor_yaw" and vectors == 3:
        assert found["pd"] <= 245
    spills = [operands for op, operands in body if op.startswith("vmovu") and "(%rsp)" in operands]
    assert not spills, "the stack is not aligned, so vectors on it cross cache lines"


@pytest.mark.parametrize("dimension", [1, 2, 4, 6])
def test_exponents_of_linear_systems_are_real_parts_of_eigenvalues(dimension: int) -> None:
    """Any dimension, as many vectors; a complex pair from two dimensions on, and far from normal."""
    rng = np.random.default_rng(12)
    blocks = np.diag([-0.1, -0.1, -0.5, -1.0, 0.1, -0.7][:dimension])
    if dimension > 1:
        blocks[0, 1], blocks[1, 0] = 2.0, -2.0
    basis = rng.normal(size=(dimension, dimension))
    matrix = basis @ blocks @ np.linalg.inv(basis)
    names = [f"x{i}" for i in range(dimension)]
    space: dict[str, Any] = {}
    rows = (" + ".join(f"{float(matrix[i, j])!r} * {names[j]}" for j in range(dimension)) for i in range(dimension))
    exec(f"def rhs({', '.join(names)}): return ({', '.join(rows)},)", space)
    program = derive(Model("linear", space["rhs"], tuple(State(name) for name in names), ()))
    layout = Layout(dimension, dimension, len(program.coefficients))
    frame = generic_frame(dimension, dimension)[None]
    lanes = layout.pack(rng.normal(size=(1, dimension)), frame, program.coefficient_values([], RK4.time_unit(0.01)))
    growth = np.zeros(dimension)
    for _ in range(2000):
        make_advance(program, RK4, layout)(lanes.reshape(-1), 0, 1, 1, 10)
        growth += np.log(layout.take_stretch(lanes, 1)[0])
    expected = np.sort(np.diag(blocks))[::-1]
    np.testing.assert_allclose(growth / 200, expected, atol=6 / 200)
    assert growth.sum() / 200 == pytest.approx(np.trace(matrix), abs=1e-8)  # |lambda|^5 dt^4 / 120 per eigenvalue


def test_every_class_of_processor_has_lanes() -> None:
    assert cpu_class() in LANES
    assert all(lanes % 8 == 0 and lanes >= 16 for lanes in LANES.values())
