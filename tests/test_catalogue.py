"""The catalogue: derived Jacobians and Hessians, symmetries, closed forms and published values of every model."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest

from quavsweep.classify import classify
from quavsweep.codes import Region
from quavsweep.config import Sweep, parse_sweep
from quavsweep.config.template import make_template
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.kernels.layout import aligned_empty, generic_frame
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.program import TIME, Program
from quavsweep.models import NAMES, Model, load_model
from quavsweep.plan import cell_values, make_plan

T = 0.7  # time at which forced systems are looked at
TINY = 1e-30  # step of complex steps


def _point(model: Model, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a state and parameters."""
    rng = np.random.default_rng(seed)
    u, count = rng.uniform(-3, 3, len(model.states)), len(model.parameters)
    return u, np.array([*model.defaults.values()]) * rng.uniform(0.5, 2.0, count) + rng.uniform(0, 1e-4, count)


def _values(program: Program, u: np.ndarray, p: np.ndarray) -> dict[str, object]:
    return {**dict(zip((*program.states, *program.parameters), (*u, *p), strict=True)), TIME: T}


def _columns(model: Model, u: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the Jacobian by complex steps."""
    columns = []
    for j in range(u.size):
        moved = u.astype(complex)
        moved[j] += TINY * 1j
        columns.append([complex(f).imag / TINY for f in model.field(moved, p, T)])
    return np.array(columns).T


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_equals_complex_steps(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    for seed in range(20):
        u, p = _point(model, seed)
        expected, values = _columns(model, u, p), _values(program, u, p)
        derived = np.array([program.evaluate(row, values) for row in program.jacobian], dtype=float)
        assert np.abs(derived - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("name", NAMES)
def test_hessian_equals_differences_of_the_jacobian(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    u, p = _point(model, 1)
    size, h = u.size, 1e-5
    for k in range(size):
        shift = h * np.eye(size)[k]
        expected = (_columns(model, u + shift, p) - _columns(model, u - shift, p)) / (2 * h)
        entries = [matrix[k] for row in program.hessian for matrix in row]
        derived = np.array(program.evaluate(entries, _values(program, u, p)), dtype=float).reshape(size, size)
        assert np.abs(derived - expected).max() <= 1e-8 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", NAMES)
def test_program_computes_what_the_function_says(name: str) -> None:
    model = load_model(name)
    program = make_program(model)
    for seed in range(5):
        u, p = _point(model, seed)
        expected = np.array(model.field(u, p, T))
        tolerance = 1e-13 * np.abs(expected).max()
        np.testing.assert_allclose(program.evaluate(program.rhs, _values(program, u, p)), expected, 1e-12, tolerance)


@pytest.mark.parametrize("name", NAMES)
def test_equations_have_the_declared_symmetries(name: str) -> None:
    model = load_model(name)
    u, p = _point(model, 3)
    for signs in model.symmetries:
        mirrored = np.array(model.field(signs * u, p, T))
        np.testing.assert_array_equal(mirrored, np.array(signs) * np.array(model.field(u, p, T)))


Parameters = dict[str, float]

DIVERGENCE: dict[str, Callable[[Parameters], float]] = {
    "bldc": lambda p: -(1 + p["delta"] + p["sigma"]),
    "chen": lambda p: p["c"] - p["a"] - p["b"],
    "duffing": lambda p: -p["delta"],
    "jerk": lambda p: -p["A"],
    "linear": lambda p: 2 * p["re"] + p["a"],
    "lorenz": lambda p: -(p["sigma"] + 1 + p["beta"]),
    "pmsm": lambda p: -(2 + p["sigma"]),
    "quadrotor_yaw": lambda p: -(p["k4"] / p["Ix"] + p["k5"] / p["Iy"] + p["k6"] / p["Iz"]),
}


@pytest.mark.parametrize("name", DIVERGENCE)
def test_divergence_is_the_closed_form(name: str) -> None:
    model = load_model(name)
    u, p = _point(model, 4)
    expected = DIVERGENCE[name](dict(zip(model.parameter_names, p, strict=True)))
    assert np.trace(_columns(model, u, p)) == pytest.approx(expected, rel=1e-13)


def _rossler_point(p: Parameters) -> tuple[float, ...]:
    z = (p["c"] - sqrt(p["c"] ** 2 - 4 * p["a"] * p["b"])) / (2 * p["a"])
    return p["a"] * z, -z, z


def _side(height: float, rate: float = 1.0) -> tuple[float, ...]:
    return sqrt(rate * height), sqrt(rate * height), height


EQUILIBRIA: dict[str, Callable[[Parameters], tuple[float, ...]]] = {
    "chen": lambda p: _side(2 * p["c"] - p["a"], p["b"]),
    "chua": lambda p: ((p["m1"] - p["m0"]) / p["m1"], 0.0, (p["m0"] - p["m1"]) / p["m1"]),
    "jerk": lambda p: (0.0, 0.0, 0.0),
    "linear": lambda p: (0.0, 0.0, 0.0),
    "lorenz": lambda p: _side(p["rho"] - 1, p["beta"]),
    "pmsm": lambda p: _side(p["gamma"] - 1)[::-1],
    "rossler": _rossler_point,
    "stuart_landau": lambda p: (0.0, 0.0),
}


@pytest.mark.parametrize("name", EQUILIBRIA)
def test_equilibria_are_the_closed_form(name: str) -> None:
    model = load_model(name)
    point = EQUILIBRIA[name](model.defaults)
    for signs in (tuple([1] * len(point)), *model.symmetries):
        assert np.abs(model.field(np.multiply(signs, point), [*model.defaults.values()])).max() < 1e-13


@pytest.mark.parametrize(("name", "damping"), [("pmsm", None), ("bldc", "delta")])
def test_motors_without_input_are_the_lorenz_system(name: str, damping: str | None) -> None:
    """As Hemati (1994) found for equal inductances."""
    model = load_model(name)
    p = model.defaults | {n: 0.0 for n in ("u_d", "u_q", "v_d", "v_q", "T_L", "eta") if n in model.defaults}
    order = [model.state_names.index(state) for state in ("w", "i_q", "i_d")]
    u, _ = _point(model, 5)
    du = np.array(model.field(u, [*p.values()]))
    flux, beta = p["gamma" if name == "pmsm" else "rho"], p[damping] if damping else 1.0
    lorenz = load_model("lorenz").field(u[order], [p["sigma"], flux, beta])
    np.testing.assert_allclose(du[order], lorenz, rtol=1e-12, atol=1e-14)


def test_the_synchronous_motor_has_a_pitchfork_and_a_hopf_point() -> None:
    """At gamma = 1 and sigma (sigma + 4) / (sigma - 2), as the Lorenz system with beta = 1."""
    model = load_model("pmsm")
    sigma = model.defaults["sigma"]
    hopf = sigma * (sigma + 4) / (sigma - 2)
    assert hopf == pytest.approx(14.93, abs=0.01)
    for shift, sign in ((-1e-6, -1), (1e-6, 1)):
        p = model.defaults | {"gamma": 1 + shift}
        assert np.sign(np.linalg.eigvals(_columns(model, np.zeros(3), np.array([*p.values()]))).real.max()) == sign
        p = model.defaults | {"gamma": hopf + shift}
        side = np.array(EQUILIBRIA["pmsm"](p))
        assert np.sign(np.linalg.eigvals(_columns(model, side, np.array([*p.values()]))).real.max()) == sign


@pytest.mark.parametrize("name", NAMES)
def test_the_example_of_a_model_runs(name: str) -> None:
    model = load_model(name)
    changes = [f"axes.{axis}.num=2" for axis in model.example.axes]  # type: ignore[union-attr]
    plan = make_plan(parse_sweep(make_template(model, name), name, changes), 16)
    layout, n = plan.layout, plan.sweep.grid.size
    parameters, u = cell_values(plan.sweep, np.arange(n))
    frame = np.broadcast_to(generic_frame(layout.dimension, layout.vectors), (n, layout.vectors, layout.dimension))
    scaled = plan.program.coefficient_values(parameters, plan.method.time_unit(plan.clock.dt))
    lanes = layout.pack(u, frame, scaled)
    dense = [aligned_empty((len(lanes), 1 + 200 * plan.clock.block, layout.dimension, layout.lanes))]
    buffer = [array.reshape(-1) for array in dense if plan.sweep.dense]
    plan.advance(lanes.reshape(-1), 0, len(lanes), 200, plan.clock.block, *buffer)
    assert model.bounded(layout.state(lanes, n)).all()


# The values of others, with what a run of this length can be held to: three standard errors beyond their own.
# Initial state, method, step, time before averaging and time of averaging are part of the row.
PUBLISHED = {
    "bldc": ((0.01, 0.01, 0.01), "rk4", 0.002, 100, 900, None, "Ge and Chang 2004: chaos"),
    "chen": ((1, 1, 20), "rk4", 0.002, 100, 900, (2.024, 0.004), "the spectrum collection; sum -10"),
    "chua": (
        (0.1, 0, 0),
        "rk4",
        0.01,
        200,
        1800,
        None,
        "Chua, Komuro and Matsumoto 1986: the double scroll is chaotic",
    ),
    "duffing": ((1, 0), "rk4", 0.02, 500, 4500, None, "gamma = 0.5 is chaotic"),
    "jerk": ((0, 0.5, 0), "rk4", 0.05, 1000, 9000, (0.0551, 0.0), "Sprott 1997"),
    "pmsm": ((20, 0.01, -5), "rk4", 0.005, 100, 1900, None, "Li et al. 2002: gamma = 20, sigma = 5.46 is chaotic"),
    "rossler": ((1, 1, 1), "rk4", 0.02, 500, 4500, (0.0714, 0.0), "Sprott"),
}


@pytest.mark.literature
@pytest.mark.parametrize("name", PUBLISHED)
def test_largest_exponents_are_the_published_ones(name: str) -> None:
    model = load_model(name)
    initial, method, dt, transient, duration, value, _ = PUBLISHED[name]
    values = _classified(_sweep(model, initial, method, dt, transient, duration))
    largest, error = values["lyapunov"][0], values["lyapunov_se"][0]
    assert values["region"] == Region.CHAOS
    assert largest > 3 * error
    if value is not None:
        assert error < 0.02 * value[0] + 0.002
        assert abs(largest - value[0]) < 3 * error + value[1]
    if name in DIVERGENCE:
        assert values["lyapunov_raw"].sum() == pytest.approx(DIVERGENCE[name](model.defaults), abs=1e-5)


@pytest.mark.parametrize(
    ("name", "initial", "exponents"),
    [
        ("stuart_landau", (0.1, 0.0), (0.0, -2.0)),
        ("torus", (0.1, 0.0, 0.0), (0.0, 0.0, -2.0)),
        ("linear", (1.0, 1.0, 1.0), (-0.2, -0.2, -0.5)),
    ],
)
def test_exponents_are_the_closed_form(name: str, initial: tuple[float, ...], exponents: tuple[float, ...]) -> None:
    """With rk4, dt = 0.02, transient 100 and duration 400, without early ends."""
    sweep = _sweep(load_model(name), initial, "rk4", 0.02, 100, 400)
    raw = _classified(sweep)["lyapunov_raw"]
    np.testing.assert_allclose(np.sort(raw)[::-1], exponents, rtol=0, atol=1e-8)


def test_a_linear_system_is_never_chaotic(make_sweep: Callable[..., Sweep]) -> None:
    """What grows without end is unbounded, also where it does so slowly."""
    sweep = make_sweep(
        make_template(load_model("linear"), "linear"),
        ("start: -1, stop: 0.1, num: 12", "start: -0.1, stop: 0.1, num: 5"),
        ("duration: 400", "duration: 2000"),
    )
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, sweep.grid.size), lambda: False)
    region = classify(sweep, evidence)["region"].reshape(sweep.grid.shape)
    real, a = (np.array(axis.values) for axis in sweep.grid.axes)
    grows = (real[:, None] > 1e-9) | (a > 1e-9)
    assert (region[grows] == Region.UNBOUNDED).all()
    assert not np.isin(region[~grows], (Region.UNBOUNDED, Region.CHAOS)).any()


def _classified(sweep: Sweep) -> dict[str, np.ndarray]:
    evidence = integrate_tile(make_plan(sweep, 16), Tile(0, 0, 1), lambda: False)
    return {name: values[0] for name, values in classify(sweep, evidence).items()}


def _sweep(
    model: Model, initial: tuple[float, ...], method: str, dt: float, transient: float, duration: float
) -> Sweep:
    start = ", ".join(f"{name}: {float(value)}" for name, value in zip(model.state_names, initial, strict=True))
    return parse_sweep(f"""
name: {model.name}
model: {model.name}
initial: {{{start}}}
integrate: {{method: {method}, dt: {dt}, transient: {transient}, duration: {duration}}}
measures: {{lyapunov: {{exponents: {len(model.states)}, block: 20}}}}
stop_early: false
""")
