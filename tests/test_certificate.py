"""Certificates: what they claim is what the integrator does, and what they cannot claim they do not."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import sympy as sp

from quavsweep.analysis.certificate import Shape, attracted, examine
from quavsweep.analysis.equilibrium import eigensystem, newton, solve, vector_field
from quavsweep.analysis.event import step
from quavsweep.analysis.interval import OPERATIONS, Interval
from quavsweep.kernels.derive import derive
from quavsweep.kernels.formula import FUNCTIONS
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.method import DP8, RK4, ButcherTable
from quavsweep.kernels.program import Program
from quavsweep.models import Model, Parameter, State, load_model
from quavsweep.models.function import absolute, maximum, where
from tests.function_models import CHUA, PENDULUM

DT = 0.02


def _yaw(omega: float) -> tuple[np.ndarray, np.ndarray]:
    """Return coefficients of one cell and the side equilibrium next to Table 3's."""
    model = load_model("quadrotor_yaw")
    program = make_program(model)
    p = model.defaults | {"Omega1": omega}
    coefficients = program.coefficient_values([np.array([value]) for value in p.values()])
    guess = np.array([[0.043, 0.1012, 0.0]]) * np.sqrt(omega) + np.array([[0, 0, 0.4443]])
    found, point = newton(program, guess, coefficients)
    assert found.all()
    return coefficients, point


@pytest.mark.literature
@pytest.mark.parametrize(
    ("omega", "point", "real"),
    [
        (100, (0.4229, 0.9938, 0.4443), (-0.0164, -0.0164, -0.1572)),
        (196.4, (0.6025, 1.4159, 0.4443), (-0.0159, -0.0159, -0.1581)),
        (260, (0.6961, 1.6358, 0.4443), (-0.0158, -0.0158, -0.1584)),  # eigenvalues: not as printed, see README
    ],
)
def test_equilibria_and_eigenvalues_of_table_3(omega: float, point: tuple[float, ...], real: tuple[float, ...]) -> None:
    coefficients, equilibrium = _yaw(omega)
    np.testing.assert_allclose(equilibrium[0], point, atol=6e-5)
    spectrum, _ = eigensystem(vector_field(make_program(load_model("quadrotor_yaw")), equilibrium, coefficients)[1])
    np.testing.assert_allclose(spectrum[0].real, real, atol=6e-5)


@pytest.mark.parametrize(("method", "dt", "least"), [(RK4, DT, 0.03), (DP8, 0.2, 0.01)])
@pytest.mark.parametrize("omega", [60.0, 196.4, 480.0])
def test_orbits_from_the_rim_of_a_certificate_fall_in(
    omega: float, method: ButcherTable, dt: float, least: float
) -> None:
    program = make_program(load_model("quadrotor_yaw"))
    coefficients, point = _yaw(omega)
    jacobian = vector_field(program, point, coefficients)[1]
    spectrum, vectors = eigensystem(jacobian)
    shape = Shape.around(jacobian, spectrum, vectors)
    level = _largest_level(program, method, dt, shape, point, coefficients)
    assert level > least
    directions = np.random.default_rng(4).normal(size=(20, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    u = (point + level * directions @ shape.to_x[0].T).T
    before = np.full(20, level)
    for _ in range(50):
        for _ in range(round(20 * DT / dt)):
            u = step(program, method, np.full(20, dt), u, np.repeat(coefficients, 20, axis=1))
        after = np.linalg.norm((u.T - point) @ shape.to_y[0].T, axis=1)
        assert (after < before).all()
        before = after


def _largest_level(
    program: Program, method: ButcherTable, dt: float, shape: Shape, point: np.ndarray, coefficients: np.ndarray
) -> float:
    low, high = 1e-9, 1e3
    for _ in range(60):
        middle = np.sqrt(low * high)
        good = shape.decreases(program, method, dt, point, coefficients, np.array([middle]))[0]
        low, high = (middle, high) if good else (low, middle)
    return low


def test_a_saddle_is_never_certified() -> None:
    model = load_model("quadrotor_yaw")
    program = make_program(model)
    coefficients, _ = _yaw(196.4)
    p = model.defaults
    top = 2 * p["d"] * (p["c"] ** 2 + 2 * p["c"] * p["Omega1"]) / p["k6"]
    ends = examine(program, RK4, DT, np.array([[0.0, 0.0, top]]), coefficients)
    assert not ends.inside[0]
    assert ends.resting[0]
    assert ends.eigenvalues[0, 0].real == pytest.approx(2.7276, abs=5e-5)


def test_a_state_far_from_every_equilibrium_is_not_certified() -> None:
    program = make_program(load_model("quadrotor_yaw"))
    coefficients, point = _yaw(196.4)
    ends = examine(program, RK4, DT, point + 0.5, coefficients)
    assert not ends.inside[0]
    assert np.isnan(ends.equilibrium).all()


def _linear(matrix: np.ndarray) -> Model:
    """Return x' = A x for a 2 x 2 matrix."""
    a, b, c, d = matrix.ravel()
    return Model(
        "linear2",
        lambda x, y, a, b, c, d: (a * x + b * y, c * x + d * y),
        (State("x"), State("y")),
        (Parameter("a", a), Parameter("b", b), Parameter("c", c), Parameter("d", d)),
    )


@pytest.mark.parametrize(
    ("matrix", "dt", "stable"),
    [
        ([[-1.0, 0.0], [0.0, -2.0]], 0.1, True),
        ([[-1.0, 100.0], [0.0, -1.1]], 0.01, True),  # far from normal
        ([[-1.0, 1.0], [0.0, -1.0]], 0.1, True),  # one eigenvector only
        ([[-0.1, 5.0], [-5.0, -0.1]], 0.1, True),
        ([[0.0, 5.0], [-5.0, 0.0]], 0.1, False),  # a centre
        ([[-1.0, 0.0], [0.0, 0.1]], 0.1, False),
        ([[-1.0, 0.0], [0.0, -40.0]], 0.1, False),  # a sink of the flow that the method cannot reach
    ],
)
def test_linear_systems(matrix: list[list[float]], dt: float, stable: bool) -> None:
    model = _linear(np.array(matrix))
    program = derive(model)
    coefficients = program.coefficient_values([np.array([value]) for value in model.defaults.values()])
    assert examine(program, RK4, dt, np.array([[0.3, -0.2]]), coefficients).inside[0] == stable


def test_the_basin_of_a_quadratic_system_is_respected() -> None:
    """x' = -x + x^2 is attracted to 0 below x = 1, and nothing at or beyond that may be certified."""
    model = Model("bounded", lambda x, a: (-a * x + x**2,), (State("x"),), (Parameter("a", 1.0),))
    program = derive(model)
    x = np.linspace(-0.99, 0.99, 199)
    coefficients = program.coefficient_values([np.ones_like(x)])
    point = np.zeros((len(x), 1))
    jacobian = np.full((len(x), 1, 1), -1.0)
    spectrum, vectors = eigensystem(jacobian)
    inside = attracted(program, RK4, 0.01, x[:, None], coefficients, point, jacobian, spectrum, vectors)
    assert inside[np.abs(x) < 0.8].all()
    assert not examine(program, RK4, 0.01, np.array([[1.0 + 1e-9]]), coefficients[:, :1]).inside[0]


def test_a_certificate_does_not_depend_on_its_neighbours() -> None:
    program = make_program(load_model("quadrotor_yaw"))
    coefficients, point = _yaw(196.4)
    rng = np.random.default_rng(6)
    u = point + rng.normal(size=(200, 3)) * np.logspace(-6, 0, 200)[:, None]
    together = examine(program, RK4, DT, u, np.repeat(coefficients, 200, axis=1))
    assert 10 < together.inside.sum() < 190
    for i in range(0, 200, 7):
        alone = examine(program, RK4, DT, u[i : i + 1], coefficients)
        assert alone.inside[0] == together.inside[i]
        np.testing.assert_array_equal(alone.equilibrium[0], together.equilibrium[i])
        np.testing.assert_array_equal(alone.eigenvalues[0], together.eigenvalues[i])


def test_elimination_solves_and_leaves_singular_systems_alone() -> None:
    rng = np.random.default_rng(7)
    matrix, right = rng.normal(size=(50, 4, 4)), rng.normal(size=(50, 4))
    matrix[3] = 0.0
    with np.errstate(all="ignore"):
        solution = solve(np.concatenate([matrix, right[:, :, None]], axis=2).transpose(1, 2, 0).copy()).T
    good = np.arange(50) != 3
    np.testing.assert_allclose(np.einsum("nij,nj->ni", matrix, solution)[good], right[good], atol=1e-10)
    assert not np.isfinite(solution[3]).any()


def test_intervals_hold_all_values() -> None:
    rng = np.random.default_rng(9)
    low = rng.uniform(-2, 2, (2, 400))
    high = low + rng.uniform(0, 1, (2, 400))
    a, b = (Interval(low[i], high[i]) for i in range(2))
    x, y = (low[i] + (high[i] - low[i]) * rng.uniform(0, 1, (30, 400)) for i in range(2))
    with np.errstate(divide="ignore", invalid="ignore"):
        for interval, values in ((a + b, x + y), (a - b, x - y), (a * b, x * y), (a / b, x / y), (2 - a, 2 - x)):
            assert (interval.low <= values).all()
            assert (values <= interval.high).all()
    assert (Interval.of(3.0).radius == 0).all()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_intervals_hold_all_values_of_functions(name: str) -> None:
    """And are not wider than they must be where the function is not near an extreme."""
    rng = np.random.default_rng(10)
    low = rng.uniform(0.01, 30, 500) if name == "log" else rng.uniform(-30, 30, 500)
    high = low + rng.choice([0.0, 1e-6, 0.1, 3.0], 500)
    with np.errstate(all="ignore"):
        box = OPERATIONS[name](Interval(low, high))
    for share in np.linspace(0, 1, 30):
        values = getattr(np, name)(np.clip(low + share * (high - low), low, high))
        assert (box.low <= values).all()
        assert (values <= box.high).all()
    narrow = high == low
    assert (
        (box.high - box.low)[narrow] == pytest.approx(0.0, abs=0)
        or ((box.high - box.low)[narrow] <= 64 * np.spacing(np.abs(box.high[narrow]).clip(1))).all()
        or name == "tan"
    )


def test_intervals_of_sines_know_their_crests() -> None:
    low, high = np.array([1.5, 4.7, 0.1, -10.0, 2e6, np.nan]), np.array([1.6, 4.8, 0.2, 10.0, 2e6, np.nan])
    box = OPERATIONS["sin"](Interval(low, high))
    assert (box.high >= [1, -0.997, 0.198, 1, 1, 1]).all()
    assert (box.low <= [0.9975, -1, 0.0999, -1, -1, -1]).all()
    assert box.high[2] < 0.1987
    assert box.low[2] > 0.0998


def test_a_comparison_that_is_not_certain_gives_all_numbers() -> None:
    left = Interval(np.array([0.0, 2.0, 0.5, np.nan]), np.array([0.5, 3.0, 1.5, np.nan]))
    box = OPERATIONS["select_less"](left, 1.0, 5.0, -7.0)
    np.testing.assert_array_equal(box.low, [5.0, -7.0, -np.inf, -np.inf])
    np.testing.assert_array_equal(box.high, [5.0, -7.0, np.inf, np.inf])


def _inside(model: Model, states: list[list[float]], dt: float = 0.01) -> list[bool]:
    program = derive(model)
    coefficients = program.coefficient_values([np.array([value]) for value in model.defaults.values()])
    coefficients = np.repeat(coefficients, len(states), axis=1)
    return examine(program, RK4, dt, np.array(states), coefficients).inside.tolist()


def test_the_sinks_of_a_pendulum_are_certified_on_every_turn() -> None:
    program, p = derive(PENDULUM), PENDULUM.defaults
    rest = np.arcsin(p["torque"] / p["stiffness"])
    u = np.array([[rest + 2 * np.pi * turn + 0.01, -0.01] for turn in (-1000, -1, 0, 1, 1000)])
    coefficients = program.coefficient_values([np.full(5, value) for value in p.values()])
    ends = examine(program, RK4, DT, u, coefficients)
    assert ends.inside.all()
    np.testing.assert_allclose(np.sin(ends.equilibrium[:, 0]), np.sin(rest), rtol=1e-11)
    swing = np.sqrt(complex(p["damping"] ** 2 / 4 - p["stiffness"] * np.cos(rest)))
    np.testing.assert_allclose(ends.eigenvalues[:, 0], -p["damping"] / 2 + swing, rtol=1e-9)
    assert _inside(PENDULUM, [[np.pi - rest, 0.0], [rest + 1.5, 0.0]]) == [False, False]


def test_a_sink_within_a_region_is_certified_and_none_across_a_kink() -> None:
    """x' = -x up to 1 and 2 - 3 x beyond: all are drawn to 0, but the certificate ends at the kink."""
    model = Model("bent", lambda x: (where(x < 1, -x, 2 - 3 * x),), (State("x"),), ())
    assert _inside(model, [[0.4], [-20.0]]) == [True, False]
    assert _inside(model, [[0.999], [1.0], [1.001]]) == [False] * 3


@pytest.mark.parametrize(
    "rhs",
    [
        lambda x: (-2 * x + absolute(x),),
        lambda x: (-x - maximum(x, 0),),
        lambda x: (-x - sp.Max(x, 0) ** 3,),  # smooth enough, but not known to be
        lambda x: (where(x < 0, -x, -x - 1e-9),),
    ],
)
def test_a_sink_on_a_kink_is_not_certified_though_all_second_derivatives_are_zero(rhs: Any) -> None:
    model = Model("kink", rhs, (State("x"),), ())
    assert _inside(model, [[1e-3], [-1e-3], [1e-12], [0.0]]) == [False] * 4


def test_chuas_outer_sinks_are_certified_within_their_region() -> None:
    p = {"alpha": 2.0, "beta": 100 / 7, "a": -8 / 7, "b": -5 / 7}
    model = dataclasses.replace(CHUA, parameters=tuple(Parameter(name, value) for name, value in p.items()))
    point = (p["b"] - p["a"]) / (1 + p["b"])
    assert point > 1
    near = [[point + 1e-3, 1e-3, -point], [-point - 1e-3, 0.0, point]]
    assert _inside(model, near) == [True, True]
    assert _inside(model, [[1.0, 0.0, -point], [0.0, 0.0, 0.0]]) == [False, False]


def test_a_model_with_roots_is_certified() -> None:
    model = Model(
        "rooted", lambda x, a: (-a * x * (1 + x**2) ** sp.Rational(1, 2),), (State("x"),), (Parameter("a", 1.0),)
    )
    program = derive(model)
    ends = examine(program, RK4, 0.01, np.array([[0.01], [1e-6]]), program.coefficient_values([np.ones(2)]))
    assert ends.inside.all()
