"""Programs: stored as data, derived once, refused where they cannot be compiled."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from quavsweep.errors import ModelError
from quavsweep.kernels.derive import derive
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.lookup import keep_program, make_program, program_key
from quavsweep.kernels.method import RK4
from quavsweep.kernels.printer import step_operations
from quavsweep.kernels.program import Program
from quavsweep.models import NAMES, Model, Parameter, State, load_model
from tests.function_models import MODELS, PENDULUM


@pytest.mark.parametrize("model", [*map(load_model, NAMES), *MODELS.values()], ids=lambda model: model.name)
def test_program_survives_storage(model: Model) -> None:
    program = derive(model)
    stored = Program.from_json(program.to_json())
    assert stored == program
    assert stored.digest == program.digest
    assert hash(stored) == hash(program)


@pytest.mark.parametrize("model", [load_model("quadrotor_yaw"), *MODELS.values()], ids=lambda model: model.name)
def test_derivation_is_repeatable(model: Model) -> None:
    assert derive(model) == derive(model)


def test_a_warm_start_does_not_import_sympy() -> None:
    make_program(load_model("lorenz"))
    code = (
        "import sys; from quavsweep.models import load_model; from quavsweep.kernels.lookup import make_program;"
        "make_program(load_model('lorenz')); sys.exit('sympy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_yaw_needs_39_operations_per_stage() -> None:
    program = make_program(load_model("quadrotor_yaw"))
    # 3 shared terms and 6 in the derivatives, 3 more in the Jacobian, 9 for each of 3 vectors; 7 sums of 12 rows.
    assert step_operations(program, RK4, Layout(3, 3, 9)) <= 4 * (18 + 27) + 7 * 12


def test_coefficients_are_hoisted() -> None:
    program = make_program(load_model("quadrotor_yaw"))
    rest = program.needed([*program.rhs, *(x for row in program.jacobian for x in row)], program.coefficients)
    assert not {ref for a in rest for ref in a.arguments} & set(program.parameters)


def _model(function: object, states: str, parameters: str = "") -> Model:
    return Model(
        "odd",
        function,  # type: ignore[arg-type]
        tuple(State(s) for s in states.split()),
        tuple(Parameter(p, 1.5) for p in parameters.split()),
    )


def test_rational_and_irrational_equations_are_compiled() -> None:
    def rhs(x, y, a):  # type: ignore[no-untyped-def]
        return a * x / (1 + x**2) - y**3, sp.sqrt(x**2 + a) * y if isinstance(x, sp.Basic) else np.sqrt(x**2 + a) * y

    program = derive(_model(rhs, "x y", "a"))
    values = {"u_x": 0.7, "u_y": -1.3, "p_a": 2.5}
    np.testing.assert_allclose(program.evaluate(program.rhs, values), rhs(0.7, -1.3, 2.5), rtol=1e-14)


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (
            lambda x: (sp.erf(x),),
            r"test_program.py:\d+: erf cannot be compiled; its equations may use .*sin.*Piecewise",
        ),
        (lambda x: (sp.floor(x),), "floor cannot be compiled"),
        (lambda x: (sp.atan2(x, 1),), "atan.* cannot be compiled"),
        (lambda x: (x ** sp.Rational(1, 3),), "power 1/3"),
        (lambda x: (2**x,), "power u_x cannot be compiled; .*exp"),
        (lambda x: (sp.Piecewise((x, x > 0)),), "no branch for all other cases"),
        (lambda x: (sp.Piecewise((x, sp.Xor(x > 0, x > 1)), (0, True)),), "condition .* cannot be compiled"),
        (lambda x: (x + sp.zoo,), r"test_program.py:\d+: .*not a finite real number"),
        (lambda x: (x * sp.sqrt(-1),), "not a finite real number"),
        (lambda x: (math.sin(x),), r"test_program.py:\d+: .* only numbers got a state.*quavsweep.models.function"),
        (lambda x: (np.sin(x),), r"test_program.py:\d+: .* only numbers got a state.*quavsweep.models.function"),
        (
            lambda x: (max(x, 0),),
            r"test_program.py:\d+: .*`if`.* decides by a state or parameter; use where, minimum and maximum",
        ),
        (lambda x: ((x > 0) * x,), "TypeError: unsupported operand"),
        (lambda x: (x, x), "2 derivatives for 1 states"),
        (lambda x: (1.0 if x > 0 else -1.0,), "`if`.* decides by a state or parameter"),
    ],
)
def test_what_cannot_be_compiled_is_named(function: object, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        derive(_model(function, "x"))


def test_a_linear_model_with_constant_derivative_is_compiled() -> None:
    program = derive(_model(lambda x, y: (1, -2 * x), "x y"))
    assert program.evaluate(program.rhs, {"u_x": 3.0, "u_y": 0.0}) == [1.0, -6.0]


def test_equal_coefficients_written_differently_keep_both_names() -> None:
    program = derive(_model(lambda x, y, a: (2 * a * x, 2.0 * a * y), "x y", "a"))
    np.testing.assert_allclose(program.coefficient_values([np.array([1.5])]).ravel(), 3.0)
    assert program.evaluate(program.rhs, {"u_x": 1.0, "u_y": 2.0, "p_a": 1.5}) == [3.0, 6.0]


@pytest.mark.parametrize(
    ("function", "expected"),
    [
        (lambda x: sp.Abs(x - 1), lambda x: abs(x - 1)),
        (lambda x: abs(x) ** 3, lambda x: abs(x) ** 3),
        (lambda x: sp.Max(x, 0, x**2), lambda x: max(x, 0, x * x)),
        (lambda x: sp.Min(2, x), lambda x: min(2, x)),
        (sp.sign, lambda x: float(x > 0) - float(x < 0)),
        (sp.Heaviside, lambda x: 0.5 * (x == 0) + (x > 0)),
        (lambda x: sp.sqrt((x - 1) ** 2), lambda x: abs(x - 1)),
        (
            lambda x: sp.Piecewise((1, x < -1), (x, sp.Or(x < 0, x >= 2)), (5, True)),
            lambda x: 1 if x < -1 else x if x < 0 or x >= 2 else 5,
        ),
        (
            lambda x: sp.Piecewise((1, sp.Eq(x, 0)), (2, sp.Ne(x, 2)), (3, True)),
            lambda x: 1 if x == 0 else 2 if x != 2 else 3,
        ),
        (lambda x: sp.Piecewise((1, sp.Not(sp.And(x > -1, x < 1))), (0, True)), lambda x: 0 if -1 < x < 1 else 1),
    ],
)
def test_choices_mean_what_sympy_says(function: object, expected: object) -> None:
    program = derive(_model(lambda x: (function(x),), "x"))  # type: ignore[operator]
    for x in (-3.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 3.0):
        assert program.evaluate(program.rhs, {"u_x": x}) == [expected(x)]  # type: ignore[operator]
    x = np.array([-3.0, 0.5, 2.0])
    np.testing.assert_array_equal(program.evaluate(program.rhs, {"u_x": x})[0], [expected(v) for v in x])  # type: ignore[operator]


def test_derivatives_of_choices_are_those_of_their_branches() -> None:
    program = derive(_model(lambda x: (sp.Max(x, 0) * abs(x),), "x"))
    for x, slope, bend in ((2.0, 4.0, 2.0), (-2.0, 0.0, 0.0)):
        assert program.evaluate([program.jacobian[0][0], program.hessian[0][0][0]], {"u_x": x}) == [slope, bend]
    assert program.switches == (("u_x", 0.0),)


def test_what_depends_on_parameters_alone_is_hoisted_out_of_functions_and_choices() -> None:
    program = derive(PENDULUM)
    rest = program.needed([*program.rhs, *(x for row in program.jacobian for x in row)], program.coefficients)
    assert not {ref for a in rest for ref in a.arguments} & {*program.parameters, "h"}
    tilted = derive(_model(lambda x, a: (sp.sin(a) * abs(a) * sp.cos(x),), "x", "a"))
    rest = tilted.needed(tilted.rhs, tilted.coefficients)
    assert [a.operation for a in rest] == ["cos", "mul"]
    assert not tilted.switches


def test_a_program_of_other_equations_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lorenz = load_model("lorenz")
    ours, other = make_program(lorenz).to_json(), make_program(load_model("rossler")).to_json()
    monkeypatch.setenv("QUAVSWEEP_CACHE", str(tmp_path / "new"))
    keep_program(lorenz, program_key(load_model("rossler")), other)
    keep_program(lorenz, "", other)
    assert make_program(lorenz).to_json() == ours
