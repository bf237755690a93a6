"""Hovering: the closed form of (22) against its equation, and the config that lies along it."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep.analysis.quadrotor.hovering import hovering_difference, hovering_speed, hovering_stretch, thrust
from quavsweep.config import load_sweep
from quavsweep.models.craft import TABLE_2
from quavsweep.paper.run import config_path

M, G, B = (TABLE_2[name].default for name in ("m", "g", "b"))


@pytest.mark.parametrize(("m", "g", "b"), [(M, G, B), (1.3, 1.62, 7e-5)])
def test_thrust_carries_the_weight_along_the_curve(m: float, g: float, b: float) -> None:
    c = np.linspace(-20.0, 20.0, 41)
    speed = hovering_speed(c, m, g, b)
    np.testing.assert_allclose(thrust(speed, c, b), m * g, rtol=1e-14)
    np.testing.assert_allclose(hovering_difference(speed, m, g, b), c, atol=1e-11)
    assert (np.diff(speed) < 0).all()


def test_rotors_of_one_speed_share_the_weight() -> None:
    assert float(hovering_speed(0.0, M, G, B)) == pytest.approx(np.sqrt(M * G / (4 * B)), rel=1e-15)
    fastest = np.sqrt(M * G / (2 * B))
    assert float(hovering_speed(fastest, M, G, B)) == pytest.approx(0.0, abs=1e-10)
    assert np.isnan(hovering_speed(1.001 * fastest, M, G, B))
    assert np.isnan(hovering_speed(2.0 * fastest, M, G, B))


def test_the_stretch_within_a_window() -> None:
    assert hovering_stretch((3, 7), (50, 500), M, G, B) == (3, 7)
    low, high = hovering_stretch((3, 7), (196, 197), M, G, B) or (0.0, 0.0)
    np.testing.assert_allclose(hovering_speed(np.array([low, high]), M, G, B), [197, 196], rtol=1e-13)
    assert hovering_stretch((3, 7), (50, 100), M, G, B) is None
    assert hovering_stretch((3, 7), (300, 500), M, G, B) is None


def test_the_shipped_curve_is_the_closed_form_to_the_last_bit() -> None:
    sweep = load_sweep(config_path("hover"))
    along = sweep.grid.axes[0].quantities
    assert along["Omega1"] == tuple(hovering_speed(np.array(along["c"]), M, G, B).tolist())
    assert along["c"] == tuple(np.linspace(3, 7, 401).tolist())


@pytest.mark.literature
def test_the_paper_hovers_where_it_says() -> None:
    assert float(hovering_speed(5.0, M, G, B)) == pytest.approx(196.4, abs=0.05)
    ends = hovering_speed(np.array([7.0, 3.0]), M, G, B)
    np.testing.assert_allclose(ends, [195.4, 197.4], atol=0.05)
    assert float(thrust(500.0, 3.0, B)) == pytest.approx(29.175, abs=5e-4)
