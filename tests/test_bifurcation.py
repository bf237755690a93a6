"""Bifurcations of equilibria: where closed forms put them, and told apart."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep import bifurcation_curve, find_bifurcations
from quavsweep.analysis.quadrotor.closed_form import pitchfork_speed
from quavsweep.errors import ConfigError
from quavsweep.models import Model, Parameter, State, load_model

YAW = load_model("quadrotor_yaw")


def _found(*arguments) -> list[tuple[str, float]]:
    return [(b.kind.value, b.value) for b in find_bifurcations(*arguments)]


def _scalar(name: str, rhs) -> Model:
    return Model(name, rhs, (State("x"),), (Parameter("mu", 0.1),))


@pytest.mark.parametrize(
    ("model", "parameter", "low", "high", "expected"),
    [
        ("lorenz", "rho", 0.0, 30.0, [("pitchfork", 1.0), ("hopf", 470 / 19), ("hopf", 470 / 19)]),
        ("quadrotor_yaw", "Omega1", 0.0, 280.0, [("pitchfork", float(pitchfork_speed(YAW.defaults)))]),
        ("quadrotor_yaw", "Omega1", 50.0, 500.0, []),
        ("quadrotor_yaw", "Ix", 3e-3, 7e-3, []),
        ("stuart_landau", "mu", -1.0, 1.0, [("hopf", 0.0)]),
        ("rossler", "c", -2.0, 0.3, [("saddle-node", -0.4)]),
        ("chen", "c", 10.0, 19.0, [("pitchfork", 17.5)]),
        ("linear", "re", -1.0, 0.3, [("hopf", 0.0)]),
        ("linear", "a", -1.0, 0.3, [("degenerate", 0.0)]),
        (_scalar("fold", lambda x, mu: (mu - x**2,)), "mu", -1.0, 1.1, [("saddle-node", 0.0)]),
        (_scalar("cross", lambda x, mu: (mu * x - x**2,)), "mu", -1.0, 1.1, [("transcritical", 0.0)]),
        (_scalar("fork", lambda x, mu: (mu * x - x**3,)), "mu", -1.0, 1.1, [("pitchfork", 0.0)]),
    ],
)
def test_bifurcations_are_where_closed_forms_put_them(model, parameter, low, high, expected) -> None:
    found = _found(model, parameter, low, high)
    assert [kind for kind, _ in found] == [kind for kind, _ in expected]
    np.testing.assert_allclose([value for _, value in found], [value for _, value in expected], atol=1e-8)


def test_hopf_of_lorenz_has_its_frequency() -> None:
    hopf = find_bifurcations("lorenz", "rho", 20.0, 30.0)[0]
    rho, beta, sigma = 470 / 19, 8 / 3, 10.0
    assert hopf.eigenvalues[0].imag == pytest.approx(np.sqrt(beta * (sigma + rho)), rel=1e-9)


def test_a_forced_system_and_an_empty_range_are_refused() -> None:
    with pytest.raises(ConfigError, match="forced system has no equilibria"):
        find_bifurcations("duffing", "gamma", 0.0, 1.0)
    with pytest.raises(ConfigError, match="no range"):
        find_bifurcations("lorenz", "rho", 2.0, 1.0)
    with pytest.raises(ConfigError, match="cannot be followed"):
        bifurcation_curve("lorenz", "transcritical", ("rho", 0.0, 2.0), ("beta", 1.0, 2.0))


def test_the_yaw_pitchfork_curve_is_the_closed_form() -> None:
    (curve,) = bifurcation_curve("quadrotor_yaw", "pitchfork", ("Omega1", 0.0, 60.0), ("c", 0.5, 7.0))
    assert {curve[0, 1], curve[-1, 1]} == {0.5, 7.0}
    np.testing.assert_allclose(curve[:, 0], pitchfork_speed({**YAW.defaults, "c": curve[:, 1]}), atol=1e-8)


def test_curves_of_folds_and_hopf_points_are_closed_forms() -> None:
    (fold,) = bifurcation_curve("rossler", "saddle-node", ("c", 0.1, 2.0), ("a", 0.1, 0.5))
    np.testing.assert_allclose(fold[:, 0] ** 2, 4 * 0.2 * fold[:, 1], atol=1e-8)
    (hopf,) = bifurcation_curve("lorenz", "hopf", ("rho", 15.0, 40.0), ("beta", 1.0, 3.0))
    np.testing.assert_allclose(hopf[:, 0], 10 * (13 + hopf[:, 1]) / (9 - hopf[:, 1]), atol=1e-8)
