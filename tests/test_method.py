"""Methods: tables check themselves, and the order shows in the error."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.method import DP8, RK4, ButcherTable, density, rooted_trees
from quavsweep.models import load_model


def test_numbers_of_rooted_trees() -> None:
    assert [len(rooted_trees(n)) for n in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]
    assert sorted(density(tree) for tree in rooted_trees(4)) == [4, 8, 12, 24]


def test_stability_polynomial_of_rk4() -> None:
    np.testing.assert_allclose(RK4.stability, [1, 1, 1 / 2, 1 / 6, 1 / 24], rtol=1e-15)


def test_stability_polynomial_of_dp8_is_the_exponential_to_its_order() -> None:
    np.testing.assert_allclose(DP8.stability[:9], 1 / np.cumprod([1, *range(1, 9)]), rtol=1e-11)


def test_a_table_that_misses_its_order_cannot_exist() -> None:
    with pytest.raises(ValueError, match="order 2"):
        ButcherTable("rk4", 4, RK4.a, (Fraction(1, 6), Fraction(1, 3), Fraction(1, 4), Fraction(1, 4)))
    with pytest.raises(ValueError, match="order 5"):
        ButcherTable("rk4", 5, RK4.a, RK4.b)
    with pytest.raises(ValueError, match="do not fit"):
        ButcherTable("rk4", 4, RK4.a, RK4.b[:3])


@pytest.mark.parametrize(("name", "u", "end"), [("quadrotor_yaw", (0.5, -0.4, 1.0), 8.0), ("lorenz", (1, 2, 20), 0.5)])
@pytest.mark.parametrize(("method", "fewest"), [(RK4, 100), (DP8, 8)])
def test_error_falls_with_the_methods_power_of_the_step(
    method: ButcherTable, fewest: int, name: str, u: tuple[float, ...], end: float
) -> None:
    model = load_model(name)
    p = list(model.defaults.values())
    exact = solve_ivp(lambda t, x: model.rhs(*x, *p), (0, end), u, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    program = make_program(model)
    layout = Layout(3, 0, len(program.coefficients))
    steps = np.round(fewest * np.sqrt(2.0) ** np.arange(7 if method.order == 4 else 5)).astype(int)
    errors = []
    for n in steps:
        coefficients = program.coefficient_values([np.array([value]) for value in p], method.time_unit(end / n))
        lanes = layout.pack(np.array([u], dtype=float), np.empty((1, 0, 3)), coefficients)
        make_advance(program, method, layout)(lanes.reshape(-1), 0, 1, 1, n)
        errors.append(np.linalg.norm(layout.state(lanes, 1)[0] - exact))
    slope = np.polyfit(np.log(end / steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(method.order, abs=0.1 if method.order == 4 else 0.5)
