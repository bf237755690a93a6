"""Cycles: closed forms, published cycles, an independent shooting, and what must never be certified."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from quavsweep.analysis import kink
from quavsweep.analysis.cycle import Cycles, CycleSearch
from quavsweep.analysis.event import locate, slope, steps_from
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.shooting import grade
from quavsweep.clock import Clock
from quavsweep.codes import CycleSymmetry
from quavsweep.kernels.derive import derive
from quavsweep.kernels.method import METHODS
from quavsweep.models import Model, Parameter, Section, State, load_model
from quavsweep.models.function import cos, sign
from tests.function_models import CHUA, PENDULUM


def _model(rhs: Any, states: str, **parameters: float) -> Model:
    names = tuple(Parameter(name, value) for name, value in parameters.items())
    return Model(rhs.__name__, rhs, tuple(State(name) for name in states.split()), names)


def oscillator(x, y, omega, mu):  # type: ignore[no-untyped-def]
    square = x**2 + y**2
    return mu * x - omega * y - x * square, omega * x + mu * y - y * square


def roessler(x, y, z, a, b, c):  # type: ignore[no-untyped-def]
    return -y - z, x + a * y, b + z * (x - c)


def torus(x, y, psi, omega):  # type: ignore[no-untyped-def]
    square = x**2 + y**2
    return x - y - x * square, x + y - y * square, omega + 0 * x


OSCILLATOR = _model(oscillator, "x y", omega=3.0, mu=1.0)
ROESSLER = _model(roessler, "x y z", a=0.2, b=0.2, c=5.7)
TORUS = dataclasses.replace(
    _model(torus, "x y psi", omega=2**0.5), states=(State("x"), State("y"), State("psi", circle=2 * np.pi))
)


class Bench:
    """Orbits of a model after a transient, and the search for their cycles."""

    def __init__(self, model: Model | str, dt: float, method: str = "rk4", lanes: int = 16) -> None:
        self.model = load_model(model) if isinstance(model, str) else model
        self.program, self.method, self.dt = derive(self.model), METHODS[method], dt
        self.search = CycleSearch(self.model, self.program, self.method, Clock(dt, 1, 1, 1, 0, 1), lanes)

    def parameters(self, **values: Any) -> list[np.ndarray]:
        n = max([np.size(v) for v in values.values()], default=1)
        given = {**self.model.defaults, **values}
        return [np.zeros(n) + np.asarray(v, dtype=float) for v in given.values()]

    def advance(self, u: np.ndarray, parameters: list[np.ndarray], time: float) -> np.ndarray:
        n, steps = len(u), round(time / self.dt)
        runs = Flow(self.program, 16).tangent(
            self.method, u, parameters, np.full(n, steps * self.dt), np.full(n, steps)
        )
        return runs[0]

    def settled(self, start: Any, time: float, **values: Any) -> tuple[np.ndarray, list[np.ndarray]]:
        parameters = self.parameters(**values)
        u = np.tile(np.asarray(start, dtype=float), (len(parameters[0]), 1))
        return self.advance(u, parameters, time), parameters


def _equal(one: Cycles, other: Cycles, which: Any = slice(None)) -> None:
    for field in dataclasses.fields(Cycles):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name)[which], field.name)


@pytest.mark.parametrize("method", ["rk4", "dp8"])
def test_a_cycle_of_closed_form(method: str) -> None:
    """r' = mu r - r^3: period 2 pi / omega, exponents 0 and -2 mu, and the point (sqrt mu, ...) of largest x."""
    bench = Bench(OSCILLATOR, 0.02, method)
    omega, mu = np.array([1.0, 3.0, 3.0, 7.0]), np.array([1.0, 1.0, 0.01, 0.3])
    u, parameters = bench.settled([0.5, 0.1], 900.0, omega=omega, mu=mu)
    cycles = bench.search.find(u, parameters, 1500)
    assert cycles.found.all()
    np.testing.assert_allclose(cycles.period, 2 * np.pi / omega, rtol=1e-10)
    np.testing.assert_allclose(cycles.exponents, np.stack([0 * mu, -2 * mu], axis=1), atol=1e-9)
    np.testing.assert_allclose(cycles.point, np.stack([np.sqrt(mu), 0 * mu], axis=1), atol=1e-9)
    assert (cycles.hits == 1).all()
    assert (cycles.symmetry == CycleSymmetry.NONE).all()
    assert np.abs(cycles.exponents[:, 0]).max() > 0, "the neutral exponent is computed, not set"


def driven(x, y, v, w, rate):  # type: ignore[no-untyped-def]
    square = x**2 + y**2
    return x - y - x * square, x + y - y * square, x - rate * v, v + x * y - 1.5 * rate * w


def test_multipliers_below_all_rounding_are_known() -> None:
    """Two states follow the cycle with rates -8 and -12: their multipliers are 1e-22 and 1e-33."""
    bench = Bench(_model(driven, "x y v w", rate=8.0), 0.02)
    u, parameters = bench.settled([0.5, 0.1, 0.0, 0.0], 50.0, rate=np.array([8.0, 1.0]))
    cycles = bench.search.find(u, parameters, 1500)
    assert cycles.found.all()
    np.testing.assert_allclose(cycles.exponents, [[0, -2, -8, -12], [0, -1, -1.5, -2]], atol=1e-8)


@pytest.mark.literature
def test_periodic_windows_of_lorenz() -> None:
    """C. Sparrow, The Lorenz equations (1982): x2y and its mirror image at 100.5, symmetric cycles at 160 and 350."""
    bench = Bench("lorenz", 0.005)
    u, parameters = bench.settled([1.0, 1.0, 20.0], 200.0, rho=np.array([100.5, 160.0, 350.0]))
    cycles = bench.search.find(u, parameters, 4000)
    assert cycles.found.all()
    kinds = CycleSymmetry.MIRRORED, CycleSymmetry.SYMMETRIC, CycleSymmetry.SYMMETRIC
    assert tuple(cycles.symmetry) == kinds
    assert np.abs(cycles.exponents[:, 0]).max() < 1e-8
    np.testing.assert_allclose(cycles.exponents.sum(axis=1), -41 / 3, atol=1e-6)


@pytest.mark.literature
def test_unstable_cycles_of_roessler() -> None:
    """P. Cvitanovic et al., ChaosBook: periods and multipliers of the two shortest cycles in the attractor."""
    bench = Bench(ROESSLER, 0.01)
    guess = np.array([[9.4610343949, -1.4327363, 1.4327363], [10.528581975, -2.3867004, 2.3867004]]) + 1e-3
    cycles = bench.search.close(guess, np.array([5.87, 11.77]), bench.parameters(c=np.full(2, 5.7)))
    assert cycles.found.all()
    np.testing.assert_allclose(cycles.period, [5.88108845586, 11.7586260717], rtol=1e-10)
    np.testing.assert_allclose(cycles.multipliers[:, 0].real, [-2.403953527, -3.512006980], rtol=5e-9)
    np.testing.assert_array_equal(cycles.hits, [1, 2])
    u = bench.advance(guess, bench.parameters(c=np.full(2, 5.7)), 0.0 + bench.dt)
    assert not bench.search.find(u, bench.parameters(c=np.full(2, 5.7)), 6000).found.any()


def test_doubled_periods_are_told_apart() -> None:
    bench = Bench(ROESSLER, 0.01)
    u, parameters = bench.settled([1.0, 1.0, 0.0], 3000.0, c=np.array([2.5, 3.5, 4.0, 4.15, 5.35]))
    cycles = bench.search.find(u, parameters, 20000)
    np.testing.assert_array_equal(cycles.hits, [1, 2, 4, 8, 3])
    assert np.abs(cycles.exponents[:, 0]).max() < 1e-8
    # The last multiplier, e.g. exp(-4.98 * 17.4), is below all rounding of the derivative and known from the volume.
    assert (np.abs(cycles.multipliers[2:, 2]) < 1e-30).all()


OMEGA = np.array([260.0, 300.0, 420.0])


@pytest.fixture(scope="module")
def yaw() -> Bench:
    return Bench("quadrotor_yaw", 0.02)


def test_an_independent_shooting_finds_the_same_cycles_of_yaw(yaw: Bench) -> None:
    u, parameters = yaw.settled([1e-3, 1e-3, 1e-3], 2000.0, Omega1=OMEGA, c=5.0)
    cycles = yaw.search.find(u, parameters, 10000)
    assert cycles.found.all()
    for i in range(len(OMEGA)):
        p = [value[i] for value in parameters]

        def run(x: np.ndarray, time: float, p: list[float] = p) -> np.ndarray:
            options: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
            return solve_ivp(lambda _, u: yaw.model.rhs(*u, *p), (0, time), x, **options).y[:, -1]

        def gap(z: np.ndarray, p: list[float] = p, run: Any = run) -> np.ndarray:
            return np.append(run(z[:-1], z[-1]) - z[:-1], yaw.model.rhs(*z[:-1], *p)[0])

        start = np.append(cycles.point[i] * (1 + 1e-4), cycles.period[i] * (1 + 1e-4))
        answer = root(gap, start, tol=1e-12).x
        assert cycles.period[i] == pytest.approx(answer[-1], rel=1e-9)
        np.testing.assert_allclose(cycles.point[i], answer[:-1], rtol=1e-8)
        shift = 1e-6 * np.eye(3)
        derivative = np.array([run(answer[:-1] + d, answer[-1]) - run(answer[:-1] - d, answer[-1]) for d in shift]).T
        values = np.linalg.eigvals(derivative / 2e-6)
        order = np.lexsort((-values.imag, -np.abs(values)))
        np.testing.assert_allclose(cycles.multipliers[i], values[order], atol=1e-5)  # of the differences
    assert np.abs(cycles.exponents[:, 0]).max() < 1e-8
    np.testing.assert_allclose(cycles.exponents.sum(axis=1), -0.19, atol=1e-8)


def test_exponents_of_cycles_agree_with_long_averages(yaw: Bench) -> None:
    """Over whole periods from a point of the cycle the derivative is that of the method, off by its error."""
    u, parameters = yaw.settled([1e-3, 1e-3, 1e-3], 2000.0, Omega1=OMEGA, c=5.0)
    cycles = yaw.search.find(u, parameters, 10000)
    time = 4 * cycles.period
    steps = np.ceil(time / yaw.dt).astype(int)
    _, derivative, volume = Flow(yaw.program, 16).tangent(yaw.method, cycles.point, parameters, time, steps)
    size = np.log(np.abs(np.linalg.eigvals(derivative))).max(axis=1) / time
    np.testing.assert_allclose(size, 0.0, atol=1e-6)
    np.testing.assert_allclose(volume / time, cycles.exponents.sum(axis=1), atol=1e-6)


def test_a_mirrored_start_finds_the_mirrored_cycle(yaw: Bench) -> None:
    omega = np.array([260.0, 300.0, 420.0, 260.0, 300.0, 420.0])
    parameters = yaw.parameters(Omega1=omega, c=5.0)
    start = np.array([[1e-3, 1e-3, 1e-3]] * 3 + [[-1e-3, -1e-3, 1e-3]] * 3)
    one = yaw.search.find(yaw.advance(start, parameters, 2000.0), parameters, 10000)
    again = yaw.search.find(yaw.advance(start, parameters, 2111.0), parameters, 10000)
    assert one.found.all()
    assert again.found.all()
    np.testing.assert_allclose(one.point, again.point, rtol=1e-8)
    for i in range(3):
        same = np.allclose(one.point[i], one.point[i + 3], rtol=1e-6)
        assert same == (one.symmetry[i] == CycleSymmetry.SYMMETRIC)
        assert one.symmetry[i] == one.symmetry[i + 3]
        np.testing.assert_allclose(one.exponents[i], one.exponents[i + 3], atol=1e-8)


def test_a_cell_does_not_depend_on_neighbours_or_lanes(yaw: Bench) -> None:
    omega = np.linspace(230.0, 450.0, 45)
    u, parameters = yaw.settled([1e-3, 1e-3, 1e-3], 1500.0, Omega1=omega, c=5.0)
    together = yaw.search.find(u, parameters, 8000)
    assert 10 < together.found.sum() < 45
    _equal(Bench("quadrotor_yaw", 0.02, lanes=32).search.find(u, parameters, 8000), together)
    for i in (0, 7, 22, 44):
        _equal(yaw.search.find(u[i : i + 1], [p[i : i + 1] for p in parameters], 8000), together, slice(i, i + 1))
    order = np.random.default_rng(3).permutation(45)
    _equal(yaw.search.find(u[order], [p[order] for p in parameters], 8000), together, order)


def test_certified_cells_stay_on_their_cycles(yaw: Bench) -> None:
    omega, c = (x.ravel() for x in np.meshgrid(np.linspace(210, 500, 15), np.linspace(3.2, 6.8, 5)))
    parameters = yaw.parameters(Omega1=omega, c=c)
    u = yaw.advance(np.full((75, 3), 1e-3), parameters, 400.0)
    early = yaw.search.find(u, parameters, 10000)
    assert early.found.sum() > 25
    late = yaw.search.find(yaw.advance(u, parameters, 4000.0), parameters, 20000)
    which = early.found
    assert late.found[which].all()
    np.testing.assert_allclose(late.point[which], early.point[which], rtol=1e-8)
    np.testing.assert_array_equal(late.hits[which], early.hits[which])


def test_chaos_is_never_certified(yaw: Bench) -> None:
    lorenz = Bench("lorenz", 0.01)
    cases = (
        (lorenz, [1.0, 1.0, 20.0], {"rho": np.linspace(28, 60, 64)}, 3000),
        (yaw, [1e-3, 1e-3, 1e-3], {"Omega1": np.linspace(239.9, 240.1, 16), "c": 5.0}, 10000),
    )
    for bench, start, values, steps in cases:
        u, parameters = bench.settled(start, 300.0, **values)
        for _ in range(8):
            assert not bench.search.find(u, parameters, steps).found.any()
            u = bench.advance(u, parameters, 40.0)


def test_sinks_are_no_cycles(yaw: Bench) -> None:
    u, parameters = yaw.settled([1e-3, 1e-3, 1e-3], 400.0, Omega1=np.array([60.0, 80.0, 100.0]), c=5.0)
    lorenz = Bench("lorenz", 0.01)
    v, others = lorenz.settled([1.0, 1.0, 20.0], 5.0, rho=np.array([0.5, 10.0, 20.0]))
    for bench, x, p, time in ((yaw, u, parameters, 150.0), (lorenz, v, others, 20.0)):
        state = x
        for _ in range(6):
            assert not bench.search.find(state, p, 3000).found.any()
            state = bench.advance(state, p, time)


def test_quasi_periodic_orbits_are_no_cycles_and_cycles_may_turn() -> None:
    bench = Bench(TORUS, 0.02)
    u, parameters = bench.settled([0.5, 0.1, 0.0], 200.0, omega=np.array([2**0.5, 1.0, 1.5]))
    assert not bench.search.find(u, parameters, 20000).found.any()  # two neutral multipliers in all of them
    turning = dataclasses.replace(
        PENDULUM, states=(State("theta", circle=2 * np.pi), State("omega")), section=Section("theta", 1.0)
    )
    maxima = dataclasses.replace(turning, section=Section("omega"))
    for model in (turning, maxima):
        bench = Bench(model, 0.02)
        u, parameters = bench.settled([0.0, 5.0], 300.0, torque=np.array([2.0, 3.0]))
        cycles = bench.search.find(u, parameters, 2000)
        assert cycles.found.all()
        assert (cycles.hits == 1).all()
        assert ((cycles.point[:, 0] >= -1e-8) & (cycles.point[:, 0] < 2 * np.pi)).all()
        np.testing.assert_allclose(cycles.exponents, [[0.0, -0.2]] * 2, atol=1e-9)  # the friction


def test_cycles_across_kinks_are_exact() -> None:
    bench = Bench(CHUA, 0.02)
    u, parameters = bench.settled([0.7, 0.0, 0.0], 1500.0, alpha=np.array([7.8, 7.9, 9.0]))
    cycles = bench.search.find(u, parameters, 10000)
    np.testing.assert_array_equal(cycles.found, [True, True, False])
    assert np.abs(cycles.exponents[:2, 0]).max() < 1e-8


def relay(x, y, damping, push):  # type: ignore[no-untyped-def]
    return y, -x - damping * y + push * sign(y)


def test_a_cycle_across_jumps_has_the_multiplier_of_the_closed_form() -> None:
    """x'' + 2 d x' + x = F sign(x'): half a turn ends at exp(-pi d / w) (x - F) + F from the other side."""
    damping = np.array([0.02, 0.05])
    model = dataclasses.replace(_model(relay, "x y", damping=0.04, push=0.2), section=Section("x", 0.0))
    bench = Bench(model, 0.02)
    parameters = bench.parameters(damping=2 * damping)
    w = np.sqrt(1 - damping**2)
    amplitude = 0.2 / np.tanh(np.pi * damping / (2 * w))
    guess = np.stack([0 * w, amplitude], axis=1)
    cycles = bench.search.close(guess, 2 * np.pi / w * 1.001, parameters)
    assert cycles.found.all()
    np.testing.assert_allclose(cycles.period, 2 * np.pi / w, rtol=1e-9)
    np.testing.assert_allclose(cycles.exponents, np.stack([0 * damping, -damping], axis=1), atol=1e-8)


def test_cycles_of_a_forced_oscillator_agree_with_an_independent_shooting() -> None:
    """Of the stroboscope: no neutral exponent, and the sum of both is the friction."""
    bench = Bench("duffing", 2 * np.pi / 1.2 / 250)
    gamma = np.array([0.1, 0.2, 0.28, 0.29, 0.65, 0.5])
    u, parameters = bench.settled([1.0, 0.0], 1000 * 2 * np.pi / 1.2, gamma=gamma)
    cycles = bench.search.find(u, parameters, 40 * 250)
    np.testing.assert_array_equal(cycles.found, [True] * 5 + [False])  # the last one is chaotic
    assert not cycles.resting.any()
    np.testing.assert_array_equal(cycles.hits[:5], [1, 1, 2, 4, 2])
    np.testing.assert_allclose(cycles.period[:5], cycles.hits[:5] * 2 * np.pi / 1.2, rtol=1e-14)
    np.testing.assert_allclose(cycles.exponents[:5].sum(axis=1), -0.3, atol=1e-9)
    for i in (1, 2):
        p = [value[i] for value in parameters]

        def run(x: np.ndarray, p: list[float] = p, time: float = cycles.period[i]) -> np.ndarray:
            options: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
            return solve_ivp(lambda t, u: bench.model.rhs(t, *u, *p), (0, time), x, **options).y[:, -1]

        answer = root(lambda x, run=run: run(x) - x, cycles.point[i] + 1e-4, tol=1e-13).x
        np.testing.assert_allclose(cycles.point[i], answer, atol=1e-9)
    for i in range(6):
        alone = bench.search.find(u[i : i + 1], [p[i : i + 1] for p in parameters], 40 * 250)
        _equal(alone, cycles, slice(i, i + 1))


def swing(t, x, v, friction, depth, omega):  # type: ignore[no-untyped-def]
    return v, -friction * v - (1 + depth * cos(omega * t)) * x


def test_a_rest_under_forcing_is_told_from_a_cycle() -> None:
    model = dataclasses.replace(
        OSCILLATOR,
        name="swing",
        rhs=swing,
        states=(State("x"), State("v")),
        parameters=(Parameter("friction", 0.2), Parameter("depth", 0.3), Parameter("omega", 1.0)),
        forcing_period=lambda omega: 2 * np.pi / omega,
    )
    bench = Bench(model, 2 * np.pi / 200)
    u, parameters = bench.settled([1e-3, 0.0], 20 * 2 * np.pi, depth=np.array([0.0, 0.3]))
    cycles = bench.search.find(u, parameters, 20 * 200)
    assert cycles.found.all()
    assert cycles.resting.all()
    np.testing.assert_allclose(cycles.point, 0.0, atol=1e-12)
    np.testing.assert_allclose(cycles.exponents[0], -0.1, atol=1e-9)
    np.testing.assert_allclose(cycles.exponents.sum(axis=1), -0.2, atol=1e-9)


def test_diverged_states_are_no_cycles(yaw: Bench) -> None:
    u = np.array([[np.nan, 0.0, 0.0], [np.inf, 1.0, 1.0], [1e300, 1e300, 1e300], [0.0, 0.0, 0.0]])
    assert not yaw.search.find(u, yaw.parameters(Omega1=np.full(4, 240.0)), 2000).found.any()


def test_numbers_of_steps_are_whole_grades() -> None:
    steps = grade(np.array([1.0, 8.0, 9.5, 100.0, 1e4]))
    assert (steps >= [1, 8, 9.5, 100, 1e4]).all()
    assert (steps[1:] <= 1.2 * np.array([8, 9.5, 100, 1e4])).all()


def test_events_are_located_alike_by_compiled_and_by_interpreted_steps() -> None:
    bench, dp8 = Bench("lorenz", 0.01), METHODS["dp8"]
    u, parameters = bench.settled([1, 1, 20], 5.0, rho=np.linspace(25, 35, 400))
    c, event, compiled = (
        bench.program.coefficient_values(parameters),
        slope(bench.program, 0),
        Flow(bench.program, 16).steps_from(dp8, u, parameters),
    )
    turning = np.flatnonzero(event(u.T, c) * event(compiled(np.full(400, 0.05), np.arange(400)), c) < 0)
    assert turning.size > 10
    u, c, own = u[turning], c[:, turning], [p[turning] for p in parameters]
    time, state = locate(Flow(bench.program, 16).steps_from(dp8, u, own), 0.05, event, u.T, c)
    times, states = locate(steps_from(bench.program, dp8, u.T, c), 0.05, event, u.T, c)
    np.testing.assert_allclose(time, times, rtol=0, atol=1e-14)
    np.testing.assert_allclose(state, states, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(event(state, c), 0.0, atol=1e-10)


def test_runs_across_kinks_share_calls_and_do_not_depend_on_their_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    bench, calls = Bench("chua", 0.01), 0
    u, parameters = bench.settled([0.1, 0, 0], 50.0, alpha=np.linspace(8.0, 9.5, 20))
    flow, time, steps = Flow(bench.program, 16), np.linspace(5.0, 9.0, 20), np.full(20, 400)

    def counted(*given: Any) -> Any:
        nonlocal calls
        calls += 1
        return locate(*given)

    monkeypatch.setattr(kink, "locate", counted)
    together = kink.tangent_across(flow, METHODS["dp8"], u, parameters, time, steps)
    shared = calls
    for i in range(20):
        one = slice(i, i + 1)
        own = [p[one] for p in parameters]
        alone = kink.tangent_across(flow, METHODS["dp8"], u[one], own, time[one], steps[one])
        for ours, theirs in zip(alone, together, strict=True):
            np.testing.assert_array_equal(ours[0], theirs[i])
    assert 0 < 3 * shared < calls - shared


def test_a_cycle_whose_map_bends_more_than_the_method_errs_is_found_around_the_methods_own() -> None:
    bench = Bench("lorenz", 0.005)
    u, parameters = bench.settled([1, 1, 20], 2000.0, rho=111.0, beta=3.5)
    cycles = bench.search.find(u, parameters, 4000)
    assert cycles.found.all()
    assert cycles.hits[0] == 13
    np.testing.assert_allclose(cycles.period, 6.366673, rtol=1e-6)  # closed by SciPy as well
    later = bench.search.find(bench.advance(u, parameters, 4000.0), parameters, 4000)
    np.testing.assert_allclose(later.point, cycles.point, rtol=0, atol=1e-6)
