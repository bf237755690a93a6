"""Equilibria of models: all of them, proved, with types; those of the yaw system against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep import find_equilibria
from quavsweep.analysis.equilibrium_type import type_name
from quavsweep.analysis.quadrotor.closed_form import (
    closed_form_equilibria,
    discriminant,
    hopf_factor,
    pair,
    pitchfork_speed,
    sign_condition,
)
from quavsweep.analysis.quadrotor.stability import no_bifurcation
from quavsweep.errors import ConfigError
from quavsweep.models import Model, Parameter, State, load_model
from quavsweep.models.function import sin
from quavsweep.paper.table_1 import agrees, random_craft

YAW = load_model("quadrotor_yaw")


def test_lorenz_has_its_three_equilibria_and_no_others() -> None:
    found = find_equilibria("lorenz")
    side = np.sqrt(8 / 3 * 27)
    np.testing.assert_allclose(found.states, [[-side, -side, 27], [0, 0, 0], [side, side, 27]], atol=1e-13)
    assert found.complete
    assert found.types == ("saddle-focus index 2", "saddle index 1", "saddle-focus index 2")
    assert find_equilibria("lorenz", {"rho": 0.9999}).types == ("stable node",)


def test_rossler_loses_both_equilibria_in_its_fold() -> None:
    found = find_equilibria("rossler")
    np.testing.assert_allclose(found.states[:, 0], 0.5 * (5.7 + np.array([-1, 1]) * np.sqrt(5.7**2 - 0.16)), rtol=1e-13)
    none = find_equilibria("rossler", {"c": 0.39})
    assert len(none) == 0
    assert none.complete


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("bldc", 3),
        ("chen", 3),
        ("chua", 3),
        ("jerk", 1),
        ("linear", 1),
        ("pmsm", 3),
        ("stuart_landau", 1),
        ("torus", 0),
    ],
)
def test_the_catalogue_is_searched_completely_up_to_its_bounds(name: str, count: int) -> None:
    found = find_equilibria(name)
    assert (len(found), found.complete) == (count, True)


def test_what_cannot_be_proved_is_said() -> None:
    at_pitchfork = find_equilibria("lorenz", {"rho": 1.0})
    assert not at_pitchfork.complete
    assert at_pitchfork.types == ("non-hyperbolic",)
    np.testing.assert_allclose(at_pitchfork.states, [[0, 0, 0]], atol=1e-6)


def test_angles_lie_within_one_turn() -> None:
    pendulum = Model(
        "pendulum",
        lambda a, v, k: (v, -sin(a) - k * v),
        (State("a", circle=2 * np.pi), State("v")),
        (Parameter("k", 0.1),),
    )
    found = find_equilibria(pendulum)
    np.testing.assert_allclose(found.states, [[0, 0], [np.pi, 0]], atol=1e-14)
    assert found.types == ("stable focus", "saddle index 1")
    assert found.complete


def test_a_box_is_kept() -> None:
    assert len(find_equilibria("lorenz", box={"x": (1.0, 100.0)})) == 1


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: find_equilibria("duffing"), "forced system has no equilibria"),
        (lambda: find_equilibria("lorenz", {"r": 1.0}), "no parameter r; it has sigma, rho, beta"),
        (lambda: find_equilibria("lorenz", box={"w": (0.0, 1.0)}), "no state w"),
        (lambda: find_equilibria("lorenz", box={"x": (1.0, 0.0)}), "no interval"),
    ],
)
def test_mistakes_are_named(call, message) -> None:
    with pytest.raises(ConfigError, match=message):
        call()


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ([-1, -2, -3], "stable node"),
        ([-1 + 1j, -1 - 1j], "stable focus"),
        ([-1 + 1j, -1 - 1j, -2], "stable node-focus"),
        ([1, 2], "unstable node"),
        ([1 + 1j, 1 - 1j, 2], "unstable node-focus"),
        ([1, -1, -2], "saddle index 1"),
        ([0.1 + 1j, 0.1 - 1j, -2], "saddle-focus index 2"),
        ([1j, -1j, -2], "non-hyperbolic"),
        ([0, -1], "non-hyperbolic"),
    ],
)
def test_types_are_named_by_their_spectra(values: list[complex], name: str) -> None:
    assert type_name(np.array(values, dtype=complex)) == name


def test_closed_forms_and_search_find_the_same_for_random_crafts() -> None:
    random = np.random.default_rng(7)
    crafts = [random_craft(random) for _ in range(60)]
    assert all(agrees(craft) for craft in crafts)
    assert {sign_condition(craft)[0] for craft in crafts} >= {"-", "+ - -", "+ + -", "+ - +"}


def test_closed_forms_solve_the_equations() -> None:
    for name, u in closed_form_equilibria(YAW.defaults).items():
        if np.isfinite(u).all():
            np.testing.assert_allclose(YAW.field(u, [*YAW.defaults.values()]), 0.0, atol=1e-14, err_msg=name)


@pytest.mark.literature
@pytest.mark.parametrize(("factor", "q", "speed"), [(2, 0.99382604, 6.3851941), (1, 1.0010532, 5.0187063)])
def test_printed_formulas_give_the_printed_numbers_with_twice_the_printed_a5(factor, q, speed) -> None:
    def a14_squared(Omega1: float) -> float:
        k = {**YAW.defaults, "Omega1": Omega1}
        Ix, Iy, Iz, Ir, d, c, k4, k5, k6 = (k[x] for x in ("Ix", "Iy", "Iz", "Ir", "d", "c", "k4", "k5", "k6"))
        a2 = np.sqrt(discriminant(k))
        a5 = factor * (Ix - Iy) * (Ir * c) ** 2 * k6
        a6, a7 = 2 * (Ix - Iy) * (Iy - Iz) * d * Ir * c**3, 4 * (Ix - Iy) * (Iy - Iz) * d * Omega1 * Ir * c**2
        a8, a9, a10 = 2 * a2 * k6 * Ir * c, 2 * (Iy - Iz) * a2 * d * c**2, 4 * (Iy - Iz) * a2 * d * Omega1 * c
        return (-a5 + a6 + a7 + a8 - a9 - a10 + (Iy - Iz) * k4 * k5 * k6) / ((Ix - Iy) * (Iy - Iz) ** 2 * k5)

    assert np.sqrt(a14_squared(100.0)) == pytest.approx(q, abs=1e-7)
    assert -a14_squared(0.0) / (a14_squared(1.0) - a14_squared(0.0)) == pytest.approx(speed, abs=1e-6)


def test_hurwitz_closed_form_is_that_of_the_characteristic_polynomial() -> None:
    random = np.random.default_rng(3)
    for _ in range(40):
        k = random_craft(random)
        for sign, name in ((1, "E2"), (-1, "E4")):
            u = closed_form_equilibria(k)[name]
            if np.isfinite(u).all():
                found = find_equilibria(YAW, k)
                values = found.eigenvalues[np.argmin(np.linalg.norm(found.states - u, axis=1))]
                _, a, b, e = np.poly(values).real
                x, y, z = k["k4"] / k["Ix"], k["k5"] / k["Iy"], k["k6"] / k["Iz"]
                bend = hopf_factor(k, sign) * pair(k, sign).q_squared / (k["Ix"] * k["Iy"] * k["Iz"])
                expected = (x + y + z) * z * (x + y) + bend
                assert a * b - e == pytest.approx(expected, rel=1e-6, abs=1e-9 * (abs(a * b) + abs(e)))


def test_no_bifurcation_crosses_the_planes_of_figures_5_and_9() -> None:
    for plane in (("c", 3.0, 7.0), ("Ix", 3e-3, 7e-3)):
        assert no_bifurcation(YAW.defaults, 50.0, *plane).holds
    assert not no_bifurcation(YAW.defaults, 6.0, "c", 3.0, 7.0).holds
    for Omega1 in (50.0, 275.0, 500.0):
        for changed in ({"c": 3.0}, {"c": 7.0}, {"Ix": 3e-3}, {"Ix": 7e-3}):
            found = find_equilibria(YAW, {"Omega1": Omega1, **changed})
            assert found.complete
            assert sorted(kind.split()[0] for kind in found.types) == ["saddle", "stable", "stable"]


def test_pitchfork_speed_is_where_the_pair_leaves_the_axis() -> None:
    speed = pitchfork_speed(YAW.defaults)
    assert speed == pytest.approx(6.385194, abs=5e-7)
    assert [len(find_equilibria(YAW, {"Omega1": speed + d})) for d in (-1e-4, 1e-4)] == [1, 3]
