"""Models: their equations against the paper's numbers, their symmetries, their derived Jacobians."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep.errors import ModelError
from quavsweep.kernels.lookup import make_program
from quavsweep.models import NAMES, Model, Parameter, State, load_model


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_equals_complex_step(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    rng = np.random.default_rng(1)
    dimension = len(model.states)
    for _ in range(20):
        u = rng.uniform(-3, 3, dimension)
        p = np.array(list(model.defaults.values())) * rng.uniform(0.5, 2.0, len(model.parameters))
        values = dict(zip((*program.states, *program.parameters), (*u, *p), strict=True))
        for j in range(dimension):
            moved = u.astype(complex)
            moved[j] += 1e-30j
            column = np.array([complex(f).imag / 1e-30 for f in model.rhs(*moved, *p)])
            derived = np.array(program.evaluate([row[j] for row in program.jacobian], values), dtype=float)
            assert np.abs(derived - column).max() <= 1e-12 * np.abs(column).max()


@pytest.mark.parametrize("name", NAMES)
def test_program_computes_what_the_function_says(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    u = np.random.default_rng(2).uniform(-3, 3, len(model.states))
    values = dict(zip((*program.states, *program.parameters), (*u, *model.defaults.values()), strict=True))
    expected = np.array(model.rhs(*u, *model.defaults.values()))
    np.testing.assert_allclose(program.evaluate(program.rhs, values), expected, rtol=1e-13)


@pytest.mark.parametrize("name", NAMES)
def test_equations_have_the_declared_symmetries(name: str) -> None:
    model = load_model(name)
    u = np.random.default_rng(3).uniform(-3, 3, len(model.states))
    du = np.array(model.rhs(*u, *model.defaults.values()))
    for signs in model.symmetries:
        mirrored = np.array(model.rhs(*(signs * u), *model.defaults.values()))
        np.testing.assert_array_equal(mirrored, np.array(signs) * du)


def test_yaw_has_the_divergence_of_its_drag() -> None:
    model = load_model("quadrotor_yaw")
    program = make_program(model)
    values = dict(zip((*program.states, *program.parameters), (0.3, -1.2, 4.0, *model.defaults.values()), strict=True))
    trace = sum(program.evaluate([program.jacobian[i][i] for i in range(3)], values))
    p = model.defaults
    assert trace == pytest.approx(-(p["k4"] / p["Ix"] + p["k5"] / p["Iy"] + p["k6"] / p["Iz"]), rel=1e-14)
    assert trace == pytest.approx(-0.19, abs=1e-12)


@pytest.mark.parametrize(
    ("omega", "point"),
    [(100, (0.4229, 0.9938, 0.4443)), (196.4, (0.6025, 1.4159, 0.4443)), (260, (0.6961, 1.6358, 0.4443))],
)
@pytest.mark.literature
def test_yaw_is_at_rest_at_the_equilibria_of_table_3(omega: float, point: tuple[float, ...]) -> None:
    model = load_model("quadrotor_yaw")
    p = model.defaults | {"Omega1": omega}
    assert np.abs(model.rhs(*point, *p.values())).max() < 2e-3
    top = 2 * p["d"] * (p["c"] ** 2 + 2 * p["c"] * omega) / p["k6"]
    assert np.abs(model.rhs(0, 0, top, *p.values())).max() < 1e-14


def test_model_refuses_arguments_that_are_not_its_names() -> None:
    with pytest.raises(ModelError, match="declares"):
        Model("odd", lambda x, a: (a * x,), (State("x"),), (Parameter("b", 1.0),))


@pytest.mark.parametrize("name", ["region", "2x", "x y"])
def test_model_refuses_names_that_would_collide(name: str) -> None:
    space: dict[str, object] = {}
    if name.isidentifier():
        exec(f"def rhs({name}): return ({name},)", space)
        with pytest.raises(ModelError, match="taken"):
            Model("odd", space["rhs"], (State(name),), ())  # type: ignore[arg-type]


def test_unknown_model_names_the_catalogue() -> None:
    with pytest.raises(ModelError, match="lorenz"):
        load_model("lorentz")
