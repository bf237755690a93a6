"""Models: what a declaration refuses, angles, and the yaw equations against the paper's numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from quavsweep.errors import ModelError
from quavsweep.kernels.lookup import make_program
from quavsweep.models import Model, Parameter, Section, State, load_model


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


def test_angles_lie_on_their_circle_and_differ_by_the_shorter_way() -> None:
    model = load_model("torus")
    u = np.array([[-9.0, 2.0, -1e-20], [9.0, 2.0, 7.0], [1.0, 1.0, 2 * np.pi], [0.0, 0.0, 3.0]])
    np.testing.assert_allclose(model.wrap(u)[:, 2], [0.0, 7.0 - 2 * np.pi, 0.0, 3.0])
    assert (model.wrap(u)[:, 2] < 2 * np.pi).all()
    np.testing.assert_array_equal(model.wrap(u)[:, :2], u[:, :2])
    apart = model.difference(np.array([[0.0, 0.0, 0.1]]), np.array([[1.0, 0.0, 2 * np.pi - 0.1]]))
    np.testing.assert_allclose(apart, [[-1.0, 0.0, 0.2]])


def test_angles_have_no_bound() -> None:
    model = load_model("torus")
    u = np.array([[0.0, 0.0, 1e9], [1e9, 0.0, 0.0], [0.0, np.nan, 0.0], [0.0, 0.0, np.inf]])
    np.testing.assert_array_equal(model.bounded(u), [True, False, False, False])


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"symmetries": ((-1,),)}, "is not 3 signs"),
        ({"symmetries": ((-1, -1, 2),)}, "is not 3 signs"),
        ({"section": Section("w")}, "section is of w, which is no state; the states are x, y, z"),
        ({"section": Section("x", direction="left")}, "direction is left; up, down or both"),
        ({"bound": 0}, "are lengths"),
        ({"name": "my model"}, "cannot be the name of a model"),
        ({"states": (State("x", circle=-1), State("y"), State("z"))}, "are lengths"),
    ],
)
def test_model_refuses_parts_that_do_not_fit(changes: dict[str, object], says: str) -> None:
    with pytest.raises(ModelError, match=says):
        replace(load_model("lorenz"), **changes)  # type: ignore[arg-type]
