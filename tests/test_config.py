"""Configs: what is read is what was meant, and what is wrong is named by file, line and key."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quavsweep.config import Sweep, dump_config, load_sweep, parse_sweep
from quavsweep.errors import ConfigError
from tests.conftest import LORENZ, YAW

CONFIGS = sorted((Path(__file__).parent.parent / "configs").rglob("*.yaml"))


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.stem)
def test_shipped_configs_are_read(path: Path) -> None:
    sweep = load_sweep(path)
    assert sweep.name == path.stem
    assert load_sweep(str(path)).canonical() == sweep.canonical()
    assert not sweep.warnings


@pytest.mark.parametrize("name", ["omega_c", "omega_ix"])
def test_the_maps_of_the_paper_have_its_times(name: str) -> None:
    sweep = load_sweep(CONFIGS[0].parent / f"{name}.yaml")
    assert sweep.grid.shape == (451, 201)
    assert (sweep.clock.transient, sweep.clock.duration, sweep.clock.dt) == (1000, 3000, 0.02)
    assert sweep.clock.batch_steps * sweep.clock.dt == 62.5


NOTHING = YAW.replace("measures: {lyapunov: {exponents: 3, block: 25}}", "")


@pytest.mark.parametrize("text", [NOTHING, NOTHING.replace("duration: 600", "duration: 301, segment: 100")])
def test_the_canonical_config_without_measures_is_a_fixed_point(text: str) -> None:
    sweep = parse_sweep(text)
    again = parse_sweep(dump_config(sweep.canonical()))
    assert again.canonical() == sweep.canonical()
    assert again.clock == sweep.clock


@pytest.mark.parametrize("text", [YAW, LORENZ])
def test_the_canonical_config_gives_the_same_sweep(text: str) -> None:
    sweep = parse_sweep(text)
    again = parse_sweep(dump_config(sweep.canonical()))
    assert again.canonical() == sweep.canonical()
    assert dataclasses.replace(again, config=sweep.config) == sweep


@pytest.mark.parametrize(
    ("change", "line", "says"),
    [
        (("name: small", "nme: small"), 2, r"nme: unknown key, did you mean name\?"),
        (("name: small\n", ""), 1, "name: is missing"),
        (("name: small", "name: a/b"), 2, "name: 'a/b' is not accepted"),
        (("model: quadrotor_yaw", "model: quadrotr"), 3, "the catalogue has .*lorenz, .*quadrotor_yaw"),
        (("p: 0.001, ", ""), 4, "initial.p: is missing; give it here, or vary it as axes.p"),
        (("p: 0.001", "p: yes"), 4, "initial.p: 'yes' is not accepted"),
        (("p: 0.001", "p: true"), 4, "initial.p: true is not accepted"),
        (("p: 0.001", "p: .inf"), 4, "initial.p: .inf is not accepted"),
        (("p: 0.001", "p: .nan"), 4, "initial.p: .nan is not accepted"),
        (("p: 0.001", "w: 1, p: 0.001"), 4, "initial.w: quadrotor_yaw has no such state; it has p, q, r"),
        (("Omega1: {start: 50", "Omga1: {start: 50"), 6, r"axes.Omga1: .* did you mean Omega1\?"),
        (("num: 9", "num: 0"), 6, "axes.Omega1.num: 0 is not accepted"),
        (("num: 9", "num: 9.5"), 6, "axes.Omega1.num: 9.5 is not accepted"),
        (("num: 9", "num: 1000000000000000000"), 6, "axes.Omega1.num"),
        (("num: 9", "values: [1]"), 6, "axes.Omega1.start: cannot stand beside axes.Omega1.values"),
        (("stop: 500, ", ""), 6, r"axes.Omega1.stop: is missing; an axis is \{start, stop, num\} or \{values\}"),
        (
            ("start: 50, stop: 500", "start: 5, stop: 5"),
            6,
            "axes.Omega1.start: 5 is also the value of axes.Omega1.stop",
        ),
        (("start: 50", "start: -50"), 6, "axes.Omega1.start: -50 rad/s is outside the domain; it must be >= 0"),
        (("num: 9", "num: 9, spacing: cubic"), 6, "axes.Omega1.spacing: 'cubic' is not accepted"),
        (("start: 50", "start: 0, spacing: log"), 6, "above 0"),
        (("{start: 3, stop: 7, num: 5}", "{values: [3, 3]}"), 7, r"axes.c.values \(item 2\): 3 is given twice"),
        (("initial:", "parameters: {c: 5}\ninitial:"), 4, "parameters.c: is fixed here and varied in axes"),
        (("initial:", "parameters: {Ix: 0}\ninitial:"), 4, "parameters.Ix: 0 kg m2 is outside the domain"),
        (("initial:", "parameters: {kx: 0}\ninitial:"), 4, "parameters.kx: quadrotor_yaw has no such parameter"),
        (("dt: 0.02", "dt: 0"), 8, "integrate.dt: 0 is not accepted"),
        (("dt: 0.02", "dt: 1e-320"), 8, "integrate.duration: 600 is more than 9e15 steps of integrate.dt"),
        (("duration: 600", "duration: 1e308"), 8, "more than 9e15 steps"),
        (("duration: 600", "duration: 1e9, segment: 1"), 8, "at most 100000 segments"),
        (("name: small", "[a, b]: 1"), 2, "a key here is a list or a mapping; keys are words"),
        (("name: small", "name: 0x" + "f" * 6000), 2, "name: 0xffffffff... has 6002 characters"),
        (("start: 3, stop: 7", "start: 3, stop: 3.0000000000000004"), 7, "not all different"),
        (("\nname: small", "%YAML 1.1\n---\nname: small"), None, "not YAML 1.2"),
        (("dt: 0.02", "dt: 700"), 8, "integrate.dt: a step of 700 is longer than integrate.duration"),
        (("name: small", "name: ../x"), 2, "name: '../x' is not accepted; it may have letters, digits"),
        (("model: quadrotor_yaw\n", ""), 1, "model: is missing; the catalogue has .*lorenz"),
        (("{method: rk4, dt: 0.02, transient: 200, duration: 600}", ""), 8, "integrate: is not a mapping of keys"),
        (("name: small", "\tname: small"), 2, "use spaces"),
        (("dt: 0.02", "dt: '0.02'"), 8, "integrate.dt: '0.02' is not accepted"),
        (("dt: 0.02, ", ""), 8, "integrate.dt: is missing; it should be a number above 0 .step."),
        (("method: rk4", "method: euler"), 8, "integrate.method: 'euler' is not accepted; it should be rk4"),
        (("duration: 600", "duration: 600, segment: 0.5"), 8, None),
        (("duration: 600", "duration: 6.0e+12, segment: 0.5"), 8, "at most 100000 segments"),
        (("exponents: 3", "exponents: 4"), 9, "quadrotor_yaw has 3 states; 1 to 3 exponents"),
        (("exponents: 3", "exponent: 3"), 9, "measures.lyapunov.exponent: unknown key, did you mean exponents"),
        (("lyapunov", "liapunov"), 9, "measures.liapunov: unknown key"),
        (("name: small", "name: small\nname: twice"), 3, "duplicate key"),
        (("name: small", "name: &a small"), 2, "anchors and aliases"),
        (("name: small", "name: !!str small"), 2, "tags are not allowed"),
        (("name: small", "name: !!python/object/apply:os.system [ls]"), 2, "tags are not allowed"),
        (("name: small", "name: [" * 30 + "]" * 30), 2, "nested deeper"),
        (("name: small", "name: {small"), 2, r"name: its \{ is not closed by \} before line 3"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(change: tuple[str, str], line: int | None, says: str | None) -> None:
    assert change[0] in YAW
    text = YAW.replace(*change)
    if says is None:
        parse_sweep(text)
        return
    with pytest.raises(ConfigError, match=says) as caught:
        parse_sweep(text, "x.yaml")
    if line is not None:
        assert str(caught.value).startswith(f"x.yaml:{line}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", [b"\xff\xfe\x00", "", "- 1", "a: b: c", "\t", "null", "%YAML 9.9\n---\na: 1"])
def test_what_is_not_a_config_is_refused(text: bytes | str) -> None:
    with pytest.raises(ConfigError):
        parse_sweep(text, "x.yaml")


@given(st.one_of(st.binary(max_size=200), st.text(max_size=200)))
@settings(max_examples=300, deadline=None)
def test_random_bytes_never_raise_anything_else(text: bytes | str) -> None:
    with pytest.raises(ConfigError):
        parse_sweep(text)


def test_numbers_without_a_point_are_floats() -> None:
    sweep = parse_sweep(YAW.replace("p: 0.001", "p: 1e-3").replace("q: 0.001", "q: 1"))
    assert sweep.config.initial == {"p": 0.001, "q": 1.0, "r": 0.001}


def test_times_are_rounded_up_to_whole_segments(make_sweep: Callable[..., Sweep]) -> None:
    clock = make_sweep(YAW, ("transient: 200, duration: 600", "transient: 100, duration: 301")).clock
    assert clock.batch_steps % clock.block == 0
    assert clock.transient >= 100
    assert clock.duration >= 301
    segment = clock.segment_steps * clock.dt
    assert clock.transient - 100 < segment
    assert clock.duration - 301 < segment
    assert clock.segments * clock.segment_steps == clock.steps


@pytest.mark.parametrize("times", [(200, 600), (1000, 3000), (1000, 4000), (100, 500), (0, 7000)])
def test_round_times_are_kept(make_sweep: Callable[..., Sweep], times: tuple[int, int]) -> None:
    sweep = make_sweep(YAW, ("transient: 200, duration: 600", f"transient: {times[0]}, duration: {times[1]}"))
    assert (sweep.clock.transient, sweep.clock.duration) == times
    assert sweep.clock.segments * sweep.clock.segment_batches >= 64
    assert not sweep.warnings


def test_a_rounded_time_is_said(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("transient: 200, duration: 600", "transient: 200, duration: 601"))
    assert re.fullmatch(r"rounded up to whole segments of \d+: .*duration 601 -> \d+", sweep.warnings[0])


def test_a_batch_can_be_asked_for(make_sweep: Callable[..., Sweep]) -> None:
    clock = make_sweep(
        YAW, ("block: 25", "block: 25, batch: 5.0"), ("duration: 600", "duration: 600, segment: 10")
    ).clock
    assert clock.batch_steps * clock.dt == 5.0
    assert clock.segment_batches == 2


def test_a_body_that_cannot_exist_is_a_warning(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("c: {start: 3, stop: 7, num: 5}", "Ix: {values: [3.0e-5, 4.9e-3]}"))
    assert sweep.warnings == (
        "Iy <= Ix + Iz does not hold in 50 % of the cells; no rigid body has such moments of inertia",
    )


@pytest.mark.parametrize(
    ("axes", "shape"),
    [
        ("{}", ()),
        ("{Omega1: {values: [100, 200]}}", (2,)),
        ("{Omega1: {values: [100]}, c: {start: 3, stop: 7, num: 2}, Ix: {start: 4e-3, stop: 5e-3, num: 3}}", (1, 2, 3)),
    ],
)
def test_any_number_of_axes(axes: str, shape: tuple[int, ...]) -> None:
    head, tail = YAW.split("axes:")[0], YAW.split("num: 5}\n")[1]
    assert parse_sweep(f"{head}axes: {axes}\n{tail}").grid.shape == shape


def test_an_axis_over_an_initial_state() -> None:
    text = YAW.replace("p: 0.001, ", "").replace("c: {start: 3, stop: 7, num: 5}", "p: {start: -2, stop: 2, num: 3}")
    sweep = parse_sweep(text)
    np.testing.assert_array_equal(sweep.grid.coordinates(0, 3)["p"], [-2, 0, 2])


def test_logarithmic_spacing() -> None:
    sweep = parse_sweep(YAW.replace("{start: 50, stop: 500, num: 9}", "{start: 1, stop: 100, num: 3, spacing: log}"))
    np.testing.assert_allclose(sweep.grid.axes[0].values, [1, 10, 100])


def test_a_config_that_is_too_large_or_missing_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "large.yaml"
    path.write_text("#" * (2**20 + 1))
    with pytest.raises(ConfigError, match="larger than"):
        load_sweep(path)
    with pytest.raises(ConfigError, match="No such file"):
        load_sweep(tmp_path / "none.yaml")
    with pytest.raises(ConfigError, match="cannot be read"):
        load_sweep(tmp_path)


def test_a_measure_that_is_only_named_has_its_defaults() -> None:
    sweep = parse_sweep(YAW.replace("{lyapunov: {exponents: 3, block: 25}}", "{lyapunov: }"))
    assert sweep.measures.vectors == 3
