"""Functions in equations: their accuracy as arrays and as machine code, and how users may write them."""

from __future__ import annotations

import math
import subprocess
import sys
from functools import cache

import mpmath
import numpy as np
import pytest
import sympy as sp

from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.derive import derive
from quavsweep.kernels.formula import FUNCTIONS, HALF_PI, LN_2, on_arrays
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.method import ButcherTable
from quavsweep.models import Model, State, function
from tests.function_models import MODELS

EULER = ButcherTable("euler", 1, ((),), (1,))
ROUNDS = 2.0**20  # sines are accurate up to here


@cache
def _near_quarter_turns(count: int) -> np.ndarray:
    """Return the floats up to 2^20 that are nearest to multiples of pi / 2, and their neighbours."""
    with mpmath.workprec(300):
        unit = int(mpmath.floor(mpmath.pi / 2 * mpmath.mpf(2) ** 150))
    near = []
    for n in range(1, int(ROUNDS / 1.5708)):
        exact = n * unit
        shift = exact.bit_length() - 53
        rounded = (exact + (1 << (shift - 1))) >> shift
        near.append((abs(exact - (rounded << shift)), math.ldexp(rounded, shift - 150)))
    x = np.array([value for _, value in sorted(near)[:count]])
    return np.concatenate([x, np.nextafter(x, np.inf), np.nextafter(x, 0)])


def _points(name: str, n: int) -> np.ndarray:
    """Return random numbers of the stated range, and those that are hard."""
    rng = np.random.default_rng(3)
    tiny = 10.0 ** rng.uniform(-300, 0, n)
    if name in ("sin", "cos", "tan"):
        parts = [rng.uniform(-size, size, n) for size in (1, 10, 1e3, ROUNDS)]
        return np.concatenate([*parts, tiny, _near_quarter_turns(500), -_near_quarter_turns(500)])
    if name == "log":
        near_1 = 10.0 ** rng.uniform(-16, -0.3, n)
        scales = 10.0 ** rng.uniform(-323, 308, n)
        return np.concatenate([rng.uniform(0.5, 2, 2 * n), scales, 1 + near_1, 1 - near_1])
    if name == "exp":
        halves = (rng.integers(-1000, 1000, n) + 0.5) * math.log(2)  # where the nearest power of two changes
        return np.concatenate(
            [rng.uniform(-size, size, n) for size in (1, 50, 709)] + [rng.uniform(-745, -707, n), halves]
        )
    return np.concatenate([rng.uniform(-size, size, n) for size in (0.7, 1.1, 20, 709)] + [tiny])


def _worst(name: str, x: np.ndarray, values: np.ndarray) -> float:
    """Return the largest error in units of the last place of the exact value."""
    worst = 0.0
    with mpmath.workprec(200):
        for at, value in zip(x.tolist(), values.tolist(), strict=True):
            exact = getattr(mpmath, name)(mpmath.mpf(at))
            unit = math.ulp(float(exact))
            worst = max(worst, float(abs(mpmath.mpf(value) - exact) / unit))
    return worst


def _compiled(name: str, x: np.ndarray) -> np.ndarray:
    """Return the values that machine code gives: one step of Euler's method of x' = 0, y' = f(x) from y = 0."""
    model = Model(name, lambda x, y: (0 * y, getattr(sp, name)(x)), (State("x"), State("y")), ())
    program = derive(model)
    layout = Layout(2, 0, len(program.coefficients))
    start = np.stack([x, np.zeros_like(x)], axis=1)
    lanes = layout.pack(start, np.empty((len(x), 0, 2)), np.repeat(program.coefficient_values([]), len(x), axis=1))
    make_advance(program, EULER, layout)(lanes.reshape(-1), 0, lanes.shape[0], 1, 1)
    return layout.state(lanes, len(x))[:, 1]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_are_within_2_ulp(name: str) -> None:
    x = _points(name, 1500)
    assert _worst(name, x, on_arrays(name)(x)) <= 2.0
    assert _worst(name, x, _compiled(name, x)) <= 2.0


@pytest.mark.slow
@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_are_within_2_ulp_at_many_points(name: str) -> None:
    x = _points(name, 100_000)
    assert _worst(name, x, on_arrays(name)(x)) <= 2.0
    assert _worst(name, x, _compiled(name, x)) <= 2.0


INF, NAN = math.inf, math.nan


@pytest.mark.parametrize(
    ("name", "x", "expected"),
    [
        *[(name, x, NAN) for name in ("sin", "cos", "tan") for x in (INF, -INF, NAN, 1e13, -1e300)],
        *[(name, NAN, NAN) for name in FUNCTIONS],
        *[(name, 0.0, 0.0) for name in ("sin", "tan", "tanh", "sinh")],
        *[(name, 0.0, 1.0) for name in ("cos", "exp", "cosh")],
        *[
            ("exp", x, y)
            for x, y in ((INF, INF), (-INF, 0.0), (710.0, INF), (-746.0, 0.0), (1e300, INF), (-1e300, 0.0))
        ],
        *[("log", x, y) for x, y in ((INF, INF), (0.0, -INF), (-1.0, NAN), (-INF, NAN), (1.0, 0.0), (-1e-310, NAN))],
        *[("tanh", x, y) for x, y in ((INF, 1.0), (-INF, -1.0), (1e300, 1.0), (-30.0, -1.0))],
        *[("sinh", x, x) for x in (INF, -INF, 5e-324)],
        *[("cosh", x, INF) for x in (INF, -INF, 1e300)],
    ],
)
def test_functions_at_their_ends(name: str, x: float, expected: float) -> None:
    assert on_arrays(name)(x) == pytest.approx(expected, abs=0, rel=0, nan_ok=True)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_machine_code_agrees_at_the_ends(name: str) -> None:
    x = np.array([0.0, INF, -INF, NAN, 1e13, -1e300, 710.0, -710.0, -746.0, 5e-324, -1e-310, 1.0])
    np.testing.assert_allclose(_compiled(name, x), on_arrays(name)(x), rtol=5e-16)


@pytest.mark.parametrize("x", [1e7, 3e9, -1e11])
def test_sines_beyond_their_range_are_those_of_a_rounded_angle(x: float) -> None:
    assert abs(float(on_arrays("sin")(x)) - math.sin(x)) <= 4 * math.ulp(x)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_values_do_not_depend_on_the_shape_of_an_array(name: str) -> None:
    x = _points(name, 50)
    together = on_arrays(name)(x)
    assert [float(on_arrays(name)(value)) for value in x] == together.tolist()
    np.testing.assert_array_equal(on_arrays(name)(x[::3]), together[::3])


def test_parts_of_constants_are_short_and_add_up() -> None:
    """All but the last have so few digits that their products with 2^20 and 2^11 are exact."""
    with mpmath.workprec(300):
        assert abs(mpmath.fsum(HALF_PI) - mpmath.pi / 2) < mpmath.mpf(2) ** -155
        assert abs(mpmath.fsum(LN_2) - mpmath.ln(2)) < mpmath.mpf(2) ** -93
    for parts, digits in ((HALF_PI, 33), (LN_2, 42)):
        assert all((math.frexp(part)[0] * 2**digits).is_integer() for part in parts[:-1])


NAMES = ("sin", "cos", "tan", "exp", "log", "sinh", "cosh", "tanh", "sqrt")


@pytest.mark.parametrize("name", NAMES)
def test_users_functions_take_floats_complex_arrays_and_symbols(name: str) -> None:
    call, x = getattr(function, name), sp.Symbol("x")
    assert call(0.5) == getattr(math, name)(0.5)
    assert call(0.5 + 1e-30j).real == pytest.approx(call(0.5), rel=1e-15)
    np.testing.assert_allclose(call(np.array([0.5])), [call(0.5)], rtol=1e-15)
    assert call(x) == getattr(sp, name)(x)


@pytest.mark.parametrize("x", [-2.0, 0.0, 1.5])
def test_users_choices_are_the_same_for_all_kinds(x: float) -> None:
    symbol = sp.Symbol("x", real=True)
    for call, expected in (
        (function.absolute, abs(x)),
        (lambda u: function.maximum(u, 1), max(x, 1)),
        (lambda u: function.minimum(1, u), min(x, 1)),
        (function.sign, (x > 0) - (x < 0)),
        (lambda u: function.where(u <= 0, u, 2 * u), x if x <= 0 else 2 * x),
    ):
        assert call(x) == expected
        assert call(np.array([x])) == [expected]
        assert call(np.float64(x)) == expected
        assert float(call(symbol).subs(symbol, x)) == expected
    assert function.maximum(x + 1e-30j, 1.0 + 0j).real == max(x, 1)


def test_a_model_with_functions_is_loaded_without_sympy() -> None:
    code = "import sys; from tests.function_models import MODELS; sys.exit('sympy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    assert len(MODELS) == 4
