"""Margins: distances that are known exactly, brackets run again on their own, stops, messages."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import ConfigError, IdentityError, StoppedError
from quavsweep.margin import Margin, find_margin, write_margin
from quavsweep.margin.direction import Domain, directions_of, hovering_curve
from quavsweep.margin.finding import Gain
from quavsweep.margin.word import unknown_words
from quavsweep.models import load_model
from quavsweep.plot.margin import make_margin_figure
from quavsweep.point import compute_point

HOPF = """
name: hopf
model: stuart_landau
parameters: {mu: -0.3, omega: 1}
initial: {x: 0.1, y: 0}
integrate: {dt: 0.05, transient: 100, duration: 1000}
measures: {lyapunov: {exponents: 2, block: 10}}
"""
LORENZ = """
name: lorenz
model: lorenz
parameters: {rho: 20}
initial: {x: 1, y: 1, z: 20}
integrate: {dt: 0.01, transient: 100, duration: 400}
measures: {lyapunov: {exponents: 3, block: 10}}
"""
YAW = """
name: yaw
model: quadrotor_yaw
axes:
  Omega1: {start: 150, stop: 250, num: 3}
  ensemble: {num: 12, seed: 1, box: {p: [-2, 2], q: [-2, 2], r: [-4, 6]}}
integrate: {dt: 0.02, duration: 400, segment: 50}
"""
FLIGHT = """
name: flight
model: quadrotor
parameters: {Ir: 3.4e-4}
initial: {p: 0.001, q: 0.001, r: 0.001, phi: 0, theta: 0, psi: 0, x: 0, y: 0, z: 200, vx: 0, vy: 0, vz: 0}
integrate: {dt: 0.02, duration: 20}
"""


def _hopf(out: Path, mu: float = -0.3, **options: object) -> Margin:
    sweep = parse_sweep(HOPF.replace("-0.3", str(mu)))
    return find_margin(sweep, out=out, reach=1.5, points=15, **options)  # type: ignore[arg-type]


def _run_again(sweep: Sweep, margin: Margin) -> int:
    """Run both ends of every bracket alone and compare; return how many there were."""
    brackets = 0
    for line in margin.lines:
        for side in line.sides:
            if side.distance is None or side.inner is None or side.outer is None:
                continue
            brackets += 1
            for probe, share in ((side.inner, 0.99), (side.outer, 1.01)):
                distance = abs(probe.values[line.direction.along] - line.direction.base)
                spacing = math.ulp(line.direction.base)
                assert side.bound or distance == pytest.approx(share * side.distance, rel=1e-9, abs=spacing)
                region = int(compute_point(sweep, probe.values).values["region"])
                assert (region != 1) == probe.answer.tumbles
            assert side.inner.answer.tumbles == line.base.answer.tumbles != side.outer.answer.tumbles
    return brackets


def test_the_distance_to_a_hopf_bifurcation_is_exact_from_both_sides(tmp_path: Path) -> None:
    for mu, distance in ((-0.3, 0.3), (0.3, -0.3)):
        margin = _hopf(tmp_path / str(mu), mu)
        growth, frequency = margin.lines
        assert growth.base.answer.what == ("sink" if mu < 0 else "periodic")
        assert growth.margin == pytest.approx(distance, rel=0.02)
        assert growth.nearest is not None
        assert growth.nearest.way.sign == (1 if mu < 0 else -1)
        assert frequency.distance is None
        assert frequency.span == (-0.5, 2.5)
        assert _run_again(parse_sweep(HOPF), margin) == 1


def test_signs_are_the_same_in_all(tmp_path: Path) -> None:
    """A distance has no sign, a change has that of the parameter, a margin that of safety."""
    for mu, to, change, margin in ((-0.3, "tumbling", 0.3, 0.3), (0.3, "safety", -0.3, -0.3)):
        line = json.loads(write_margin(_hopf(tmp_path / str(mu), mu)).read_text())["directions"][0]
        assert line["to"] == to
        assert line["distance"] == pytest.approx(0.3, rel=0.02)
        assert (line["change"], line["margin"]) == pytest.approx((change, margin), rel=0.02)
        changes = [side["change"] for side in line["sides"] if side["change"] is not None]
        assert changes == [line["change"]]


def test_gains_follow_the_leading_direction_beyond_the_reach(tmp_path: Path) -> None:
    """At reach 0.5 no change of mu is seen; at four times that there is, and omega does not move it."""
    margin = find_margin(parse_sweep(HOPF), out=tmp_path, reach=0.5, points=10)
    assert margin.leading.distance is None
    (gain,) = margin.gains
    assert gain.base is not None
    assert gain.base.margin == pytest.approx(0.3, rel=0.02)
    assert gain.per_percent == pytest.approx(0.0, abs=1e-3)
    assert unknown_words(gain, "1") == ""
    near = find_margin(parse_sweep(HOPF), out=tmp_path / "near", reach=0.1, points=4)
    assert math.isnan(near.gains[0].per_percent)
    assert unknown_words(near.gains[0], "1") == "no change from -0.42 to -0.18"


def test_a_bound_is_no_distance_to_reckon_gains_with(tmp_path: Path) -> None:
    line = _hopf(tmp_path).leading
    close = dataclasses.replace(line, sides=tuple(dataclasses.replace(side, bound=True) for side in line.sides))
    gain = Gain("omega", True, line, line, line)
    assert gain.per_percent == 0
    for odd in (Gain("omega", True, close, line, line), Gain("omega", True, line, line, close)):
        assert math.isnan(odd.per_percent) == (odd.below is close)
        assert math.isnan(odd.from_below)
    assert unknown_words(Gain("omega", True, line, close, line), "1") == "not known: a distance is only a bound"


def test_brackets_of_the_lorenz_system_run_again(tmp_path: Path) -> None:
    sweep = parse_sweep(LORENZ)
    margin = find_margin(sweep, out=tmp_path, points=20)
    assert not margin.base.answer.tumbles
    assert [line.direction.name for line in margin.lines] == ["sigma", "rho", "beta"]
    assert [gain.name for gain in margin.gains] == ["rho", "beta"]
    rho = margin.lines[1]
    assert rho.nearest is not None
    assert rho.nearest.way.sign == 1
    assert 13.926 < rho.direction.base + (rho.distance or 0) < 24.74
    assert _run_again(sweep, margin) >= 2


def test_a_stopped_margin_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    whole = write_margin(_hopf(tmp_path / "whole")).read_bytes()
    stop, looks = threading.Event(), []

    def observe(progress: object) -> None:
        looks.append(progress)
        if len({id(look) for look in looks}) > 1:  # a second run has begun
            stop.set()

    with pytest.raises(StoppedError):
        _hopf(tmp_path / "parts", observe=observe, stop=stop)
    fresh = []
    again = _hopf(tmp_path / "parts", observe=lambda progress: fresh.append((progress, progress.cells_run)))
    assert write_margin(again).read_bytes() == whole
    assert max(cells for run, cells in fresh if run is fresh[0][0]) == 0  # the first run was not done twice
    data = json.loads(whole)
    assert data["directions"][0]["sides"][1]["outer"]["what"] == "periodic"
    assert len(data["runs"]) == len(again.runs)
    with pytest.raises(IdentityError):
        find_margin(parse_sweep(HOPF), out=tmp_path / "parts", reach=1.5, points=16)


def test_shares_of_starts_carry_binomial_errors(tmp_path: Path) -> None:
    margin = find_margin(parse_sweep(YAW), "basin", out=tmp_path, points=2, reach=0.3)
    assert "axes over Omega1" in margin.notes[0]
    assert "Omega1 = 196.4" in margin.notes[0]
    for line in margin.lines:
        for side in line.sides:
            for _, probe in side.scan:
                numbers = probe.answer.numbers
                assert numbers["share"] * 12 == pytest.approx(round(numbers["share"] * 12))
                assert 0 < numbers["share_se"] < 0.15
                assert probe.answer.tumbles == (numbers["share"] > 0.05)
    assert [line.direction.name for line in margin.lines][-1] == "hovering"


def test_the_roll_angle_of_a_flight(tmp_path: Path) -> None:
    margin = find_margin(parse_sweep(FLIGHT), "angle", out=tmp_path, points=10, reach=0.2)
    speed = margin.leading
    assert speed.nearest is not None
    assert speed.nearest.inner is not None
    assert speed.nearest.outer is not None
    inner, outer = (probe.answer.numbers["peak_degrees"] for probe in (speed.nearest.inner, speed.nearest.outer))
    assert abs(inner) <= 60 < abs(outer)
    gains = {gain.name: gain for gain in margin.gains}
    assert gains["l"].per_percent == 0
    assert not gains["l"].enters
    assert gains["Iy"].per_percent < 0 < gains["Iz"].per_percent
    figure = make_margin_figure(margin)
    assert len(figure.axes) == 2


def test_lines_end_where_the_model_does() -> None:
    model = load_model("quadrotor_yaw")
    domain = Domain(model, model.defaults)
    lines = {line.name: line for line in directions_of(model, model.defaults)}
    up = domain.way(lines["Iy"], 1, 0.5, 100)
    assert up.limit == pytest.approx(model.defaults["Ix"] + model.defaults["Iz"] - model.defaults["Iy"])
    assert up.ended_by == "Iy <= Ix + Iz"
    assert domain.way(lines["Ir"], -1, 2.0, 100).ended_by == "Ir > 0"
    assert domain.way(lines["c"], -1, 2.0, 100).ended_by == ""


def test_thrust_is_weight_along_the_hovering_curve() -> None:
    craft = load_model("quadrotor_yaw").defaults
    curve = hovering_curve(craft)
    for distance in (-2.0, 0.0, 1.5):
        values = curve.values(distance)
        thrust = 2 * 2.9e-5 * (values["Omega1"] ** 2 + (values["Omega1"] + values["c"]) ** 2)
        assert thrust == pytest.approx(0.468 * 9.81, rel=1e-12)
    assert curve.values(0.0)["Omega1"] == pytest.approx(196.4, abs=0.05)
    assert math.isnan(curve.values(1e4)["Omega1"])


def test_what_cannot_be_asked_is_told() -> None:
    with pytest.raises(ConfigError, match=r"has no roll angle phi.*model: quadrotor has it"):
        find_margin(parse_sweep(HOPF), "angle")
    with pytest.raises(ConfigError, match=r"no default box of starts for stuart_landau.*ensemble"):
        find_margin(parse_sweep(HOPF), "basin")
    for within in (math.inf, math.nan, 0.001):
        with pytest.raises(ConfigError, match=r"^margin by angle: .* a finite time of at least a step, 0.02 s"):
            find_margin(parse_sweep(FLIGHT), "angle", within=within)
    with pytest.raises(ConfigError, match=r"a share of 100 % of the starts .* less than 100 %"):
        find_margin(parse_sweep(YAW), "basin", share=1.0)
    with pytest.raises(ConfigError, match="region, basin, angle"):
        find_margin(parse_sweep(HOPF), "luck")
    with pytest.raises(ConfigError, match="cannot be scanned"):
        find_margin(parse_sweep(HOPF), reach=0.0)


def test_the_command(tmp_path: Path) -> None:
    config = tmp_path / "hopf.yaml"
    config.write_text(HOPF)
    command = [sys.executable, "-m", "quavsweep", "margin", str(config), "--reach", "150", "--points", "15"]

    def run(*more: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*command, *more], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)

    done = run()
    assert done.returncode == 0, done.stderr
    assert all(len(line) <= 80 for line in done.stdout.splitlines())
    assert {"margin.json", "margin.png"} <= {path.name for path in (tmp_path / "results/hopf-margin/region").iterdir()}
    assert run().stdout.splitlines()[:12] == done.stdout.splitlines()[:12]
    assert run("--max-time", "0.001", "--out", "other").returncode == 75
    assert run("--points", "16").returncode == 4
    angle = run("--by", "angle")
    assert angle.returncode == 2
    assert "model: quadrotor has it" in angle.stderr
