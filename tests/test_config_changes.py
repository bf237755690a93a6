"""Overrides of the command line: typed by the schema, put where they belong, named when they are wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from quavsweep.config import dump_config, load_sweep, parse_sweep
from quavsweep.errors import ConfigError
from tests.conftest import YAW


def test_a_change_is_as_if_it_were_written(tmp_path: Path) -> None:
    path = tmp_path / "yaw.yaml"
    path.write_text(YAW)
    sweep = load_sweep(path, ["axes.c.num=101", "name=test"])
    assert sweep.canonical() == parse_sweep(YAW.replace("num: 5", "num: 101").replace("small", "test")).canonical()


@pytest.mark.parametrize(
    ("changes", "shape"),
    [
        ([], (9, 5)),
        (["axes.Omega1={values: [240]}"], (1, 5)),
        (["axes.c="], (9,)),
        (["axes.c=", "axes.Omega1="], ()),
        (["axes.c.num=3", "axes.c.num=4"], (9, 4)),
        (["axes.Ix={start: 4e-3, stop: 5e-3, num: 2}"], (9, 5, 2)),
        (["axes.Ix.start=4e-3", "axes.Ix.stop=5e-3", "axes.Ix.num=2"], (9, 5, 2)),
        ([" axes . c . num = 7 "], (9, 7)),
        (["axes={}"], ()),
    ],
)
def test_axes_are_changed(changes: list[str], shape: tuple[int, ...]) -> None:
    assert parse_sweep(YAW, changes=changes).grid.shape == shape


def test_sections_on_the_way_are_made() -> None:
    sweep = parse_sweep(YAW, changes=["parameters.Ix=5e-3", "classify.errors=4", "measures.lyapunov.batch=5"])
    assert sweep.parameters["Ix"] == 5e-3
    assert sweep.config.classify.errors == 4
    assert sweep.clock.batch_steps * sweep.clock.dt == 5


def test_an_empty_section_is_filled() -> None:
    text = YAW.replace("{lyapunov: {exponents: 3, block: 25}}", "{lyapunov: }")
    sweep = parse_sweep(text, changes=["measures.lyapunov.exponents=2"])
    assert sweep.measures.vectors == 2


def test_a_changed_sweep_is_canonical_too() -> None:
    sweep = parse_sweep(YAW, changes=["axes.c={values: [3, 4]}", "stop_early=false"])
    assert parse_sweep(dump_config(sweep.canonical())).canonical() == sweep.canonical()


@pytest.mark.parametrize(
    ("change", "key", "says"),
    [
        ("axes.c.num=abc", "axes.c.num", "'abc' is not accepted; it should be a whole number from 1 to 1000000 "),
        ("axes.c.num=0", "axes.c.num", "0 is not accepted; "),
        ("axes.c.num=", "axes.c.num", "is missing; "),
        ("axes.c.nmu=3", "axes.c.nmu", "unknown key, did you mean num?"),
        ("axes.d=", "axes.d", "cannot be removed, it is not there; there is Omega1, c"),
        ("axes.d.num=", "axes.d.num", "cannot be removed, it is not there; nothing is there"),
        ("axes.Omega1.start=-5", "axes.Omega1.start", "-5 rad/s is outside the domain; "),
        ("axes.c={values: [3, x]}", "axes.c.values (item 2)", "'x' is not accepted; "),
        ("name.x=5", "name.x", "name (x.yaml:2) is a value and has no keys"),
        ("initial.p=", "initial.p", "is missing; give it here, or vary it as axes.p in axes (x.yaml:5)"),
        ("integrate.dt=0,02", "integrate.dt", "'0,02' is not accepted; it should be a number above 0 (step; decimals "),
        ("integrate.dt=700", "integrate.dt", "a step of 700 is longer than integrate.duration (x.yaml:8); at most 600"),
        ("integrate.duration=0.01", "integrate.duration", "0.01 is shorter than a step, integrate.dt (x.yaml:8)"),
        ("integrate.segment=1e9", "integrate.segment", "1e+09 is longer than integrate.transient (x.yaml:8) + "),
        ("axes.c=&a 5", "axes.c", "anchors and aliases are not allowed; "),
        ("axes.c=!!str 5", "axes.c", "tags are not allowed; "),
        ("axes.c={num: 1, num: 2}", "axes.c.num", "duplicate key; "),
        ("axes.c={num: ", "axes.c.num", "a value is expected, not the end of the text"),
        ("axes.c={num: 5", "axes.c", "its { is not closed by }; the last key read is axes.c.num"),
        ("name=\udcff", "name", "the byte 0xff is not UTF-8 text"),
        ("name=a\x07", "name", "the character U+0007 is not allowed"),
        ("name=--- a\n--- b", "", "a second document begins here; "),
        ("na\nme=3", r"'na\nme'", "unknown key"),
    ],
)
def test_what_is_wrong_with_a_change_names_it(change: str, key: str, says: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_sweep(YAW, "x.yaml", [change])
    message = str(caught.value)
    shown = change.replace("\n", r"\n").replace("\x07", r"\x07").replace("\udcff", r"\udcff")
    assert message.startswith(f"--set {shown}: {key}{': ' if key else ''}{says}")
    assert message.isprintable()


@pytest.mark.parametrize(
    "change", ["name=" + "x" * 2000, "name=[" + "[" * 2000, "x" * 2000 + "=5", "a" + ".b" * 2000 + "=5"]
)
def test_a_long_change_is_shown_in_part(change: str) -> None:
    with pytest.raises(ConfigError, match=r"^--set .{57}\.\.\.: "):
        parse_sweep(YAW, "x.yaml", [change])


@pytest.mark.parametrize("change", ["", "=", "=5", "axes.c.num", "a..b=5", ".a=5", "a.=5", " =5"])
def test_what_is_no_change_is_told_how_to_write_one(change: str) -> None:
    with pytest.raises(ConfigError, match=r"is not an override; KEY=VALUE, e\.g\. axes\.c\.num=101"):
        parse_sweep(YAW, "x.yaml", [change])


def test_errors_of_the_file_keep_their_lines() -> None:
    text = YAW.replace("dt: 0.02", "dt: x")
    with pytest.raises(ConfigError, match=r"^x.yaml:8: integrate.dt: 'x'"):
        parse_sweep(text, "x.yaml", ["name=test"])
    assert parse_sweep(text, "x.yaml", ["integrate.dt=0.02"]).clock.dt == 0.02
