"""The quadrotor: (13) from (7), (15) as its special case, its flight against SciPy, and what it may not leave."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from quavsweep.analysis.turn import turns
from quavsweep.classify import classify
from quavsweep.codes import Region, Status
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import ConfigError, ModelError
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.kernels.description import describe_model, read_description
from quavsweep.kernels.observe import observe
from quavsweep.measures import Evidence
from quavsweep.models import Model, Observable, Parameter, State, load_model
from quavsweep.paper.figure_12 import largest
from quavsweep.paper.run import config_path
from quavsweep.plan import make_plan
from quavsweep.provenance import identify
from quavsweep.result import open_result
from quavsweep.sweep import run_sweep

NAMES = ("quadrotor_yaw", "quadrotor_attitude", "quadrotor")
AXES = "xyz"


def _states(model: Model, n: int = 50) -> np.ndarray:
    return np.random.default_rng(1).uniform(-1.2, 1.2, (n, len(model.states)))


def _named(model: Model, names: list[str], u: np.ndarray) -> np.ndarray:
    return observe(model, names, u, model.defaults)


def _evidence(sweep: Sweep, lanes: int = 16) -> Evidence:
    return integrate_tile(make_plan(sweep, lanes), Tile(0, 0, sweep.grid.size), lambda: False)


@pytest.mark.parametrize("name", NAMES)
def test_the_four_torques_add_up_to_the_change_of_angular_momentum(name: str) -> None:
    model, p = load_model(name), load_model(name).defaults
    u = _states(model)
    for i, axis in enumerate(AXES):
        parts = _named(model, [f"{kind}_torque_{axis}" for kind in ("inertial", "gyro", "drag", "rotor")], u)
        total = _named(model, [f"torque_{axis}"], u)[:, 0]
        change = [p[f"I{axis}"] * model.field(one, [*p.values()])[i] for one in u]
        size = np.abs(parts).sum(axis=1)
        assert (np.abs(parts.sum(axis=1) - total) <= 4e-16 * size).all()
        assert (np.abs(total - change) <= 4e-16 * size).all()


@pytest.mark.parametrize("name", NAMES)
def test_casimir_power_is_supplied_less_dissipated_and_the_rate_of_the_energy(name: str) -> None:
    model, h = load_model(name), 1e-5
    u = _states(model)
    power, supplied, dissipated = _named(model, ["casimir_power", "supplied_power", "dissipated_power"], u).T
    torques = _named(model, [f"{kind}_torque_{axis}" for kind in ("inertial", "gyro") for axis in AXES], u)
    size = np.abs(torques).sum(axis=1) + np.abs(supplied) + dissipated
    assert (np.abs(power - (supplied - dissipated)) <= 1e-15 * size).all()
    flow = np.array([model.field(one, [*model.defaults.values()]) for one in u], dtype=float)
    ahead, behind = (_named(model, ["casimir_energy"], u + s * h * flow)[:, 0] for s in (1, -1))
    np.testing.assert_allclose((ahead - behind) / (2 * h), power, rtol=1e-6, atol=1e-9)


def test_attitude_is_the_printed_system() -> None:
    """Equation (13) with (12), written out."""
    model = load_model("quadrotor_attitude")
    rng = np.random.default_rng(2)
    for _ in range(20):
        p, q, r = rng.uniform(-2, 2, 3)
        v = {name: default * rng.uniform(0.5, 2) for name, default in model.defaults.items()}
        o1, o2, o3, o4 = (v[f"Omega{i}"] for i in (1, 2, 3, 4))
        omega = o2 + o4 - o1 - o3
        roll, pitch = v["b"] * v["l"] * (o4**2 - o2**2), v["b"] * v["l"] * (o3**2 - o1**2)
        yaw = v["d"] * (o4**2 + o2**2 - o3**2 - o1**2)
        expected = (
            ((v["Iy"] - v["Iz"]) * q * r - v["Ir"] * omega * q - v["k4"] * p + roll) / v["Ix"],
            ((v["Iz"] - v["Ix"]) * p * r + v["Ir"] * omega * p - v["k5"] * q + pitch) / v["Iy"],
            ((v["Ix"] - v["Iy"]) * p * q - v["k6"] * r + yaw) / v["Iz"],
        )
        np.testing.assert_allclose(model.field((p, q, r), [*v.values()]), expected, rtol=1e-12)


def test_inertial_torque_is_that_of_the_matrix() -> None:
    """-S(I omega) omega with S of (9)."""
    model = load_model("quadrotor_attitude")
    inertia = np.array([model.defaults[f"I{axis}"] for axis in AXES])
    for omega in _states(model):
        x, y, z = inertia * omega
        matrix = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
        found = _named(model, [f"inertial_torque_{axis}" for axis in AXES], omega)
        np.testing.assert_allclose(found, -matrix @ omega, rtol=1e-12, atol=1e-18)


def test_the_yaw_manoeuvre_is_a_special_case_of_the_attitude() -> None:
    yaw, attitude = load_model("quadrotor_yaw"), load_model("quadrotor_attitude")
    rng = np.random.default_rng(3)
    for u in _states(yaw):
        speed, c = rng.uniform(50, 500), rng.uniform(3, 7)
        p = yaw.defaults | {"Omega1": speed, "c": c}
        of = {"Omega1": speed, "Omega2": speed + c, "Omega3": speed, "Omega4": speed + c}
        q = {name: of.get(name, default) for name, default in attitude.defaults.items()}
        expected = np.array(yaw.field(u, [*p.values()]))
        np.testing.assert_allclose(attitude.field(u, [*q.values()]), expected, rtol=1e-11, atol=1e-13)


ORBIT = """
name: orbit
model: {model}
parameters: {parameters}
initial: {{p: 0.001, q: 0.001, r: 0.001}}
axes: {{Ix: {{values: [4.9e-3, 5.5e-3]}}}}
integrate: {{method: dp8, dt: 0.1, duration: 100}}
measures: {{orbit: {{every: 1}}}}
stop_early: false
"""


@pytest.mark.parametrize("speed", [30.0, 100.0, 260.0])
def test_orbits_of_the_special_case_are_the_same_and_regular_ones_are_those_of_scipy(speed: float) -> None:
    integrate = pytest.importorskip("scipy.integrate")
    four = f"{{Omega1: {speed}, Omega3: {speed}, Omega2: {speed + 5}, Omega4: {speed + 5}}}"
    orbits = [
        _evidence(parse_sweep(ORBIT.format(model=model, parameters=parameters)))["orbit"]
        for model, parameters in (("quadrotor_yaw", f"{{Omega1: {speed}}}"), ("quadrotor_attitude", four))
    ]
    assert np.abs(orbits[0] - orbits[1]).max() < 1e-9
    model = load_model("quadrotor_yaw")
    p = [*(model.defaults | {"Omega1": speed}).values()]
    times = np.arange(101.0)
    truth = integrate.solve_ivp(
        lambda t, u: model.field(u, p), (0, 100), [1e-3] * 3, "DOP853", times, rtol=1e-13, atol=1e-15
    )
    assert np.abs(orbits[0][0] - truth.y.T).max() < 1e-9


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    folder = tmp_path_factory.mktemp("cases")
    run_sweep(parse_sweep(config_path("cases").read_text()), folder)
    return open_result(folder)  # type: ignore[return-value]


def test_impacts_and_peaks_of_the_cases_are_those_of_scipy(cases) -> None:  # type: ignore[no-untyped-def]
    integrate = pytest.importorskip("scipy.integrate")
    model = load_model("quadrotor")
    start = [cases.sweep.config.initial[name] for name in model.state_names]
    index = {name: i for i, name in enumerate(model.state_names)}

    def impact(t: float, u: np.ndarray) -> float:
        return float(u[index["z"]])

    impact.terminal = True  # type: ignore[attr-defined]
    for case in range(3):
        p = model.defaults | {name: float(cases[name][case]) for name in ("Ix", "Iy", "Ir")}
        values = [*p.values()]
        truth = integrate.solve_ivp(
            lambda t, u, values=values: model.field(u, values),
            (0, 60),
            start,
            "DOP853",
            rtol=1e-10,
            atol=1e-12,
            events=impact,
            dense_output=True,
        )
        if not truth.t_events[0].size:
            assert np.isnan(cases["first_time"][case])
            continue
        end = float(truth.t_events[0][0])
        assert cases["first_time"][case] == pytest.approx(end, abs=1e-4)
        time = np.arange(0, end, 1e-3)
        u = truth.sol(time)
        az = [model.field(one, values)[index["vz"]] for one in u.T]
        for name, course in (("phi", u[index["phi"]]), ("theta", u[index["theta"]]), ("az", np.array(az))):
            k = int(np.argmax(np.abs(course)))
            at, value = largest(cases, name, case, end)
            assert value == pytest.approx(course[k], abs=1e-4)
            assert at == pytest.approx(time[k], abs=2e-3)


def test_turns_of_a_wave_are_where_they_are() -> None:
    time = np.arange(0, 10, 0.05)
    at, value = turns(time, np.cos(3 * time + 0.2))
    expected = (np.pi * np.arange(1, 10) - 0.2) / 3
    np.testing.assert_allclose(at, expected[: len(at)], atol=1e-8)
    np.testing.assert_allclose(np.abs(value), 1.0, atol=1e-10)


TILT = """
name: tilt
model: quadrotor
initial: {q: 1, r: 0, phi: 0, theta: 0, psi: 0, x: 0, y: 0, z: 0, vx: 0, vy: 0, vz: 0}
parameters: {c: 0}
axes: {p: {values: [0, 1e-3]}}
integrate: {method: dp8, dt: 0.05, duration: 32, segment: 4}
measures:
  peak: {of: [theta, casimir_energy], until: 1}
  orbit: {every: 0.5}
  first_time: {of: theta, above: 1.5}
  statistics: {of: [theta], after: 0}
"""


def test_a_craft_that_pitches_over_leaves_the_domain() -> None:
    """Without roll and yaw the pitch angle is the integral of q = exp(-k5 t / Iy), and passes pi/2."""
    sweep = parse_sweep(TILT)
    evidence = _evidence(sweep)
    rate = sweep.model.defaults["k5"] / sweep.model.defaults["Iy"]
    passes = -np.log(1 - rate * np.pi / 2) / rate
    assert (evidence["status"] == Status.LEFT_DOMAIN).all()
    assert evidence["steps"][0] == int(passes / sweep.clock.dt)
    time = evidence["steps"][0] * sweep.clock.dt
    theta = sweep.model.state_names.index("theta")
    assert evidence["state"][0, theta] == pytest.approx((1 - np.exp(-rate * time)) / rate, abs=1e-9)
    assert evidence["state"][0, theta] < np.pi / 2
    found = classify(sweep, evidence)
    assert (found["region"] == Region.UNDECIDED).all()
    assert found["time_used"][0] == pytest.approx(time)
    stored = np.isfinite(evidence["orbit"][0]).all(axis=1)
    times = sweep.dimensions["time"].values
    np.testing.assert_array_equal(stored, times <= time)
    assert evidence["first_time"][0] == pytest.approx(-np.log(1 - rate * 1.5) / rate, abs=1e-9)
    assert np.isfinite(evidence["peak"]).all()  # the window of the peak ends before
    assert np.isnan(evidence["statistic_mean"]).all()


def test_a_window_that_the_orbit_does_not_reach_has_no_peak() -> None:
    assert np.isnan(_evidence(parse_sweep(TILT, changes=["measures.peak.until=30"]))["peak"]).all()


@pytest.mark.parametrize("measures", ["{}", "{lyapunov: {exponents: 1, block: 5}}"])
def test_a_state_that_comes_back_between_two_looks_has_left(measures: str) -> None:
    """A damped oscillator that spirals into a sink, but first swings through the border."""

    def rhs(x, v, k):  # type: ignore[no-untyped-def]
        return v, -k * x - 0.2 * v

    text = (
        "{name: a, model: spring, initial: {v: 0}, axes: {x: {values: [1, 3]}}, "
        f"integrate: {{dt: 0.05, duration: 320, segment: 20}}, measures: {measures}}}"
    )
    spring = Model("spring", rhs, (State("x", low=-2), State("v")), (Parameter("k", 1.0),))
    free = dataclasses.replace(spring, states=(State("x"), State("v")))
    evidence, without = (_evidence(parse_sweep(text, model=model)) for model in (spring, free))
    assert evidence["status"].tolist() == [Status.ENDED_SINK, Status.LEFT_DOMAIN]
    assert (without["status"] == Status.ENDED_SINK).all()
    assert 2.0 < evidence["steps"][1] * 0.05 < np.pi
    sweep = parse_sweep(text, model=spring)
    assert classify(sweep, evidence)["region"].tolist() == [Region.SINK, Region.UNDECIDED]
    for name in ("state", "equilibrium"):
        np.testing.assert_array_equal(evidence[name][0], without[name][0])


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("theta: 0", "theta: 2"), r"initial.theta: 2 rad is outside the domain; it must be > -1.57.* and < 1.57"),
        (("axes: {p: {values: [0, 1e-3]}}", "axes: {ensemble: {num: 4, box: {p: [0, 2]}}}"), ""),
    ],
)
def test_initial_states_lie_in_the_domain(change: tuple[str, str], says: str) -> None:
    if says:
        with pytest.raises(ConfigError, match=says):
            parse_sweep(TILT.replace(*change))
        varied = TILT.replace("theta: 0, ", "").replace("p: {values: [0, 1e-3]}", "theta: {values: [0, 1.58]}")
        with pytest.raises(ConfigError, match=r"axes.theta.values \(item 2\): 1.58 rad is outside the domain"):
            parse_sweep(varied.replace("{q: 1", "{p: 0, q: 1"))
        drawn = varied.replace("theta: {values: [0, 1.58]}", "ensemble: {num: 64, box: {theta: [0, 3]}}")
        with pytest.raises(ConfigError, match=r"axes.ensemble.box.theta.*outside the domain"):
            parse_sweep(drawn.replace("{q: 1", "{p: 0, q: 1"))
    else:
        parse_sweep(TILT.replace(*change))


STATISTICS = """
name: statistics
model: quadrotor_yaw
initial: {p: 0.001, q: 0.001, r: 0.001}
axes: {Omega1: {start: 100, stop: 280, num: 7}}
integrate: {method: rk4, dt: 0.02, transient: 200, duration: 600}
measures:
  statistics: {of: [casimir_power, p, r], after: 123.46}
  samples: {section: {of: casimir_power, at: 0, direction: down}, max: 50}
  peak: {of: [casimir_power], until: 100}
  last_time: {of: casimir_power, at: 0.001}
"""


def test_statistics_do_not_depend_on_lanes_or_tiles() -> None:
    sweep = parse_sweep(STATISTICS)
    whole = _evidence(sweep)
    plan = make_plan(sweep, 32)
    parts = [integrate_tile(plan, Tile(0, a, b), lambda: False) for a, b in ((0, 1), (1, 4), (4, 7))]
    for name, values in whole.items():
        np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), values)


def test_statistics_and_samples_of_an_observable_are_those_of_the_orbit() -> None:
    sweep = parse_sweep(STATISTICS.replace("measures:\n", "measures:\n  orbit: {every: 0.02}\n"))
    evidence, model = _evidence(sweep), sweep.model
    first = sweep.clock.steps_of(123.46)
    for cell, speed in enumerate(sweep.grid.axes[0].values):
        p = model.defaults | {"Omega1": speed}
        orbit = evidence["orbit"][cell]
        course = np.c_[observe(model, ["casimir_power"], orbit, p), orbit[:, [0, 2]]][first:]
        mean = (0.5 * (course[1:] + course[:-1])).mean(axis=0)
        np.testing.assert_allclose(evidence["statistic_mean"][cell], mean, rtol=1e-10, atol=1e-15)
        np.testing.assert_array_equal(evidence["statistic_min"][cell], course.min(axis=0))
        np.testing.assert_array_equal(evidence["statistic_max"][cell], course.max(axis=0))
        count = min(50, evidence["sample_count"][cell])
        power = observe(model, ["casimir_power"], evidence["samples"][cell, :count], p)
        assert (np.abs(power) < 1e-12).all()
        early = observe(model, ["casimir_power"], orbit[: sweep.clock.steps_of(100) + 1], p)[:, 0]
        most = early[np.argmax(np.abs(early))]
        assert evidence["peak"][cell, 0] == pytest.approx(most, rel=1e-4)
        assert abs(evidence["peak"][cell, 0]) >= abs(most)


def test_a_sweep_without_observables_does_not_depend_on_them() -> None:
    sweep = parse_sweep(STATISTICS)
    plain = parse_sweep(STATISTICS.split("measures:", maxsplit=1)[0] + "measures: {peak: {of: [p]}}")
    for one, changes in ((sweep, True), (plain, False)):
        other = dataclasses.replace(one.model, observables=one.model.observables[:1])
        changed = dataclasses.replace(one, model=other)
        assert (identify(changed).evidence != identify(one).evidence) is changes


def test_a_description_has_observables_and_domains() -> None:
    model = load_model("quadrotor")
    mine = dataclasses.replace(model, name="mine")
    read = read_description(describe_model(mine))
    assert read.states == mine.states
    assert read.observable_names == mine.observable_names
    u = _states(model)
    names = [*model.observable_names]
    np.testing.assert_array_equal(observe(read, names, u, model.defaults), observe(model, names, u, model.defaults))
    assert [read.quantity(name).unit for name in names] == [o.unit for o in model.observables]
    with pytest.raises(ValueError, match="program"):
        read_description(describe_model(mine).replace('"u_q"', '"u_zz"'))


@pytest.mark.parametrize(
    ("observable", "says"),
    [
        (Observable("p", lambda p: p), "the name p is taken"),
        (Observable("peak", lambda p: p), "the name peak is taken"),
        (Observable("E", lambda w: w), "E takes w, which the model does not declare"),
        (Observable("E", 3), "E is 3, which is no function"),  # type: ignore[arg-type]
    ],
)
def test_what_is_wrong_with_an_observable_is_named(observable: Observable, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        Model("m", lambda p, a: (a * p,), (State("p"),), (Parameter("a", 1.0),), observables=(observable,))


def test_observables_of_a_forced_system_know_the_time() -> None:
    model = Model(
        "driven",
        lambda t, x, w: (-x,),
        (State("x"),),
        (Parameter("w", 2.0),),
        forcing_period=lambda w: 6.283185307179586 / w,
        observables=(Observable("phase", lambda t, w: t * w), Observable("twice", lambda x: 2 * x)),
    )
    found = observe(model, ["phase", "twice"], np.array([[1.0], [3.0]]), {"w": 2.0}, np.array([0.5, 1.0]))
    np.testing.assert_array_equal(found, [[1.0, 2.0], [2.0, 6.0]])
