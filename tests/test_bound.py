"""Bounds of the energy: the ellipsoid of zero power, the true maximum on it, and orbits that end below it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from quavsweep.analysis.quadrotor.bound import (
    energy_ellipsoid,
    largest_energy,
    theorem_1_energy,
    theorem_1_holds,
    zero_power_ellipsoid,
)
from quavsweep.models.quadrotor_yaw import MODEL

TABLE_2 = {p.name: p.default for p in MODEL.parameters}
RANDOM = [7 * seed + 1 for seed in range(40)]


def _craft(seed: int) -> dict[str, float]:
    """Return parameters, each up to e times or 1/e of that of Table 2, of a rigid body; some with a negative c."""
    rng = np.random.default_rng(seed)
    while True:
        craft = {name: value * float(np.exp(rng.uniform(-1, 1))) for name, value in TABLE_2.items()}
        craft["c"] *= rng.choice([-0.5, 1.0])
        moments = sorted(craft[name] for name in ("Ix", "Iy", "Iz"))
        if moments[2] <= moments[0] + moments[1]:
            return craft


def _energy(u: np.ndarray, craft: dict[str, float]) -> np.ndarray:
    return 0.5 * (craft["Ix"] * u[..., 0] ** 2 + craft["Iy"] * u[..., 1] ** 2 + craft["Iz"] * u[..., 2] ** 2)


def _power(u: np.ndarray, craft: dict[str, float]) -> np.ndarray:
    """Return the power from the equations of motion, not from formula (20)."""
    du = np.stack(MODEL.rhs(u[..., 0], u[..., 1], u[..., 2], **craft), axis=-1)
    return (np.array([craft["Ix"], craft["Iy"], craft["Iz"]]) * u * du).sum(axis=-1)


@pytest.mark.parametrize("seed", RANDOM)
def test_power_vanishes_on_the_ellipsoid_and_nowhere_else(seed: int) -> None:
    craft, rng = _craft(seed), np.random.default_rng(seed)
    ellipsoid = zero_power_ellipsoid(craft)
    direction = rng.normal(size=(100, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    surface = ellipsoid.centre + ellipsoid.semi_axes * direction
    scale = np.abs(_power(ellipsoid.centre, craft))
    assert np.abs(_power(surface, craft)).max() < 1e-12 * scale
    assert (_power(ellipsoid.centre + 0.99 * ellipsoid.semi_axes * direction, craft) > 0).all()
    assert (_power(ellipsoid.centre + 1.01 * ellipsoid.semi_axes * direction, craft) < 0).all()
    np.testing.assert_allclose(ellipsoid.value(surface), 0.0, atol=1e-12 * ellipsoid.level)


@pytest.mark.parametrize("seed", RANDOM)
def test_the_largest_energy_is_that_of_a_numeric_maximisation(seed: int) -> None:
    craft = _craft(seed)
    ellipsoid, found = zero_power_ellipsoid(craft), largest_energy(craft)
    scale = float(theorem_1_energy(craft))

    def on_surface(angles: np.ndarray) -> np.ndarray:
        polar, azimuth = angles
        direction = [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]
        return ellipsoid.centre + ellipsoid.semi_axes * np.array(direction)

    starts = np.random.default_rng(seed).uniform([0, 0], [np.pi, 2 * np.pi], size=(12, 2))
    runs = [
        minimize(lambda a: -_energy(on_surface(a), craft) / scale, start, tol=1e-13, method="Nelder-Mead")
        for start in starts
    ]
    best = -min(run.fun for run in runs) * scale
    assert best == pytest.approx(float(found.energy), rel=1e-9)
    assert float(_energy(found.at, craft)) == pytest.approx(float(found.energy), rel=1e-12)
    assert abs(float(ellipsoid.value(found.at))) < 1e-12 * ellipsoid.level
    assert bool(theorem_1_holds(craft)) == (float(found.energy) <= float(theorem_1_energy(craft)) * (1 + 1e-12))


def test_random_crafts_know_both_cases() -> None:
    holds = [bool(theorem_1_holds(_craft(seed))) for seed in RANDOM]
    assert 5 < sum(holds) < 35


def test_theorem_1_holds_at_table_2_but_not_with_less_drag_in_roll() -> None:
    assert bool(theorem_1_holds(TABLE_2))
    assert float(largest_energy(TABLE_2).energy) == pytest.approx(0.43517, abs=5e-6)
    less = {**TABLE_2, "k4": 6e-5}
    assert not bool(theorem_1_holds(less))
    assert float(theorem_1_energy(less)) == pytest.approx(0.43517, abs=5e-6)
    assert float(largest_energy(less).energy) == pytest.approx(0.58832, abs=5e-6)


def test_arrays_of_crafts_give_what_each_gives() -> None:
    crafts = [_craft(seed) for seed in RANDOM]
    together = largest_energy({name: np.array([craft[name] for craft in crafts]) for name in TABLE_2})
    for i, craft in enumerate(crafts):
        alone = largest_energy(craft)
        assert together.energy[i] == alone.energy
        assert (together.at[i] == alone.at).all()


def test_equilibrium_1_has_the_energy_of_theorem_1() -> None:
    ellipsoid = zero_power_ellipsoid(TABLE_2)
    e1 = 2.0 * ellipsoid.centre
    assert max(map(abs, MODEL.rhs(*e1, **TABLE_2))) < 1e-12
    bound = energy_ellipsoid(TABLE_2, float(theorem_1_energy(TABLE_2)))
    assert abs(float(bound.value(e1))) < 1e-12 * bound.level


@pytest.mark.parametrize("seed", RANDOM[:6])
def test_orbits_from_far_outside_end_inside_and_stay(seed: int) -> None:
    craft = _craft(seed)
    bound = float(largest_energy(craft).energy)
    start = np.random.default_rng(seed).normal(size=3)
    start *= np.sqrt(30.0 * bound / float(_energy(start, craft)))
    assert float(_energy(start, craft)) == pytest.approx(30.0 * bound)
    orbit = solve_ivp(
        lambda t, u: MODEL.rhs(*u, **craft), (0, 1500), start, method="DOP853", rtol=1e-9, atol=1e-12, max_step=2.0
    )
    energy = _energy(orbit.y.T, craft)
    inside = energy <= bound * (1 + 1e-7)  # where E1 is a sink, energy tends to the bound from above
    entered = int(inside.argmax())
    assert inside[entered:].all()
    assert inside[-1]
    assert (np.diff(energy[: entered + 1]) < 0).all()  # outside, energy falls


def test_an_orbit_from_equilibrium_1_exceeds_theorem_1_where_it_does_not_hold() -> None:
    craft = {**TABLE_2, "k5": 1e-4}
    assert not bool(theorem_1_holds(craft))
    e1 = np.array([0.0, 0.0, 2.0 * zero_power_ellipsoid(craft).centre[2]])
    near = np.array([5e-6, 8e-6, 0.0])
    orbit = solve_ivp(
        lambda t, u: MODEL.rhs(*u, **craft), (0, 20), e1 + near, method="DOP853", rtol=1e-11, atol=1e-14,
        max_step=0.005,
    )  # fmt: skip
    highest = _energy(orbit.y.T, craft).max()
    assert 1.001 * float(theorem_1_energy(craft)) < highest < float(largest_energy(craft).energy)
