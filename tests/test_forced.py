"""Forced systems: the time in kernels and events, whole periods in the clock, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quavsweep.codes import Certificate
from quavsweep.config import Sweep, dump_config, parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.layout import generic_frame
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.method import DP8, RK4, ButcherTable
from quavsweep.kernels.step import choose_layout
from quavsweep.models import Model, Parameter, State, load_model
from quavsweep.models.function import cos
from quavsweep.plan import make_plan
from quavsweep.step_check import check_step
from tests import twin

EPS = np.finfo(float).eps
DUFFING = """
name: forced
model: duffing
initial: {x: 1, v: 0}
axes: {gamma: {start: 0.2, stop: 0.65, num: 20}}
integrate: {method: rk4, dt: 0.02, transient: 50, duration: 150}
measures: {lyapunov: {exponents: 2, block: 10}}
stop_early: false
"""


@pytest.mark.parametrize(("vectors", "split"), [(0, False), (2, False), (2, True)])
@pytest.mark.parametrize(("method", "ulps"), [(RK4, 4), (DP8, 64)])
def test_a_forced_step_equals_the_naive_twin(method: ButcherTable, ulps: int, vectors: int, split: bool) -> None:
    model, dt, t, n = load_model("duffing"), 0.05, 0.7, 20
    program, rng = make_program(model), np.random.default_rng(1)
    layout = choose_layout(program, method, vectors, 16)
    if split:
        layout = replace(layout, scratch=method.stages * program.dimension**2)
    u, frame = rng.uniform(-1, 1, (n, 2)), np.broadcast_to(generic_frame(2, vectors), (n, vectors, 2))
    parameters = np.outer([*model.defaults.values()], rng.uniform(0.9, 1.1, n))
    lanes = layout.pack(u, frame, program.coefficient_values(list(parameters), method.time_unit(dt)))
    layout.set_phase(lanes, t)
    make_advance(program, method, layout)(lanes.reshape(-1), 0, lanes.shape[0], 1, 1)
    state, stretch = layout.state(lanes, n), layout.take_stretch(lanes, n)
    np.testing.assert_allclose(lanes[:, layout.phase_row], t + dt, rtol=2 * EPS)
    for cell in range(n):
        p = list(parameters[:, cell])
        after, moved = twin.step(model, list(u[cell]), [list(q) for q in frame[cell]], p, dt, method, t)
        assert np.abs(state[cell] - after).max() <= ulps * EPS * np.abs(after).max()
        np.testing.assert_allclose(stretch[cell], twin.gram_schmidt(moved)[1], rtol=1e-13)


@pytest.mark.parametrize(("method", "tolerance"), [("rk4", 1e-6), ("dp8", 1e-11)])
def test_a_forced_orbit_is_that_of_another_integrator(
    make_sweep: Callable[..., Sweep], method: str, tolerance: float
) -> None:
    sweep = make_sweep(DUFFING, ("rk4", method), ("block: 10}", "block: 10}, samples: {maxima: x, max: 9}"))
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, 3), lambda: False)
    end = sweep.clock.steps * sweep.clock.dt
    for cell, gamma in enumerate(sweep.grid.axes[0].values[:3]):
        p = [(sweep.parameters | {"gamma": gamma})[name] for name in sweep.model.parameter_names]
        exact = solve_ivp(
            lambda t, u, p=p: sweep.model.field(u, p, t),
            (0, end),
            [1, 0],
            "DOP853",
            rtol=1e-13,
            atol=1e-14,
            events=lambda t, u: u[1],
        )
        assert np.abs(evidence["state"][cell] - exact.y[:, -1]).max() < tolerance
        times = evidence["sample_time"][cell, : evidence["sample_count"][cell]]
        turns = exact.t_events[0]
        assert max(np.abs(turns - time).min() for time in times[:9]) < 10 * tolerance


def test_the_sum_of_the_exponents_of_a_forced_oscillator_is_its_damping(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(DUFFING, ("rk4", "dp8"))
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, 20), lambda: False)
    sums = evidence["growth_total"][:, -1].sum(axis=1) / (sweep.clock.steps * sweep.clock.dt)
    np.testing.assert_allclose(sums, -sweep.parameters["delta"], rtol=1e-12)


def test_a_forced_cell_does_not_depend_on_its_tile(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(DUFFING)
    whole = integrate_tile(make_plan(sweep, 32), Tile(0, 0, 20), lambda: False)
    part = integrate_tile(make_plan(sweep, 16), Tile(3, 17, 20), lambda: False)
    for name, values in part.items():
        assert values.tobytes() == whole[name][17:].tobytes(), name


@pytest.mark.parametrize(
    "change",
    [
        ("block: 10", "block: 25"),
        ("block: 10", "block: 400"),
        ("block: 10", "block: 7, batch: 3.0"),
        ("dt: 0.02", "dt: 0.0123"),
        ("duration: 150", "duration: 150, segment: 17"),
        ("measures: {lyapunov: {exponents: 2, block: 10}}", "measures: {orbit: {every: 1}}"),
    ],
)
def test_batches_have_whole_periods(make_sweep: Callable[..., Sweep], change: tuple[str, str]) -> None:
    sweep = make_sweep(DUFFING, change)
    clock, period = sweep.clock, sweep.model.forcing(sweep.parameters)
    assert clock.batch_steps % clock.period_steps == 0
    assert clock.period_steps * clock.dt == pytest.approx(period, rel=1e-14)
    assert clock.dt <= 0.02
    again = parse_sweep(dump_config(sweep.canonical()))
    assert again.clock == clock
    assert again.canonical() == sweep.canonical()
    assert not [w for w in again.warnings if "period" in w]


def test_a_changed_step_is_told(make_sweep: Callable[..., Sweep]) -> None:
    assert make_sweep(DUFFING).warnings[0].startswith("integrate.dt 0.02 -> 0.0193925, so that a period")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("gamma: {start: 0.2", "omega: {start: 0.2"), r":5: axes.omega: omega changes the period.*state on a circle"),
        (("axes:", "parameters: {omega: 1.0e-300}\naxes:"), "dt: 0.02 goes more than 9e15 times into the period"),
        (("axes:", "parameters: {omega: 1.0e-320}\naxes:"), "parameters.omega: makes the period of the forcing inf"),
    ],
)
def test_a_period_that_cannot_be_is_refused(
    make_sweep: Callable[..., Sweep], change: tuple[str, str], says: str
) -> None:
    with pytest.raises(ConfigError, match=says):
        make_sweep(DUFFING, change)


def test_an_axis_of_one_value_may_set_the_period(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(DUFFING, ("axes: {", "axes: {omega: {values: [2.0]}, "))
    assert sweep.clock.period_steps * sweep.clock.dt == pytest.approx(np.pi)


def test_a_frequency_is_swept_with_the_phase_as_a_state() -> None:
    def rhs(x, v, phase, delta, gamma, omega):  # type: ignore[no-untyped-def]
        return v, gamma * cos(phase) - delta * v + x - x**3, omega

    states = (State("x"), State("v"), State("phase", "rad", circle=2 * np.pi))
    model = Model("swept", rhs, states, (Parameter("delta", 0.3), Parameter("gamma", 0.2), Parameter("omega", 1.2)))
    text = DUFFING.replace("duffing", "swept").replace("v: 0", "v: 0, phase: 0").replace("gamma: {", "omega: {")
    sweep = parse_sweep(text.replace("start: 0.2, stop: 0.65, num: 20", "values: [0.8, 1.5]"), model=model)
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, 2), lambda: False)
    np.testing.assert_array_equal(evidence["certificate"], Certificate.CYCLE)
    np.testing.assert_allclose(evidence["period"], [2 * np.pi / 0.8, 2 * np.pi / 1.5], rtol=1e-9)


def test_half_the_step_is_checked_in_phase(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(DUFFING, ("gamma: {start: 0.2, stop: 0.65, num: 20}", "gamma: {values: [0.2, 0.25]}"))
    found = check_step(make_plan(sweep, 16), Tile(0, 0, 2), np.ones(2, bool), 1e9, lambda: False)
    assert found is not None
    assert 1e-10 < found.largest < 1e-6


def test_the_time_of_a_forced_program_must_be_given() -> None:
    program = make_program(load_model("duffing"))
    with pytest.raises(ValueError, match="without a time"):
        program.names(np.zeros((2, 1)), np.zeros((len(program.coefficients), 1)))
