"""Errors of a config that concern its text or two of its keys: both keys and their lines are told."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from quavsweep.config import parse_sweep
from quavsweep.config.scalar import scalar
from quavsweep.errors import ConfigError
from tests.conftest import YAW

BLOCK = """name: small
model: quadrotor_yaw
initial:
  p: 0.001
  q: 0.001
  r: 0.001
axes:
  Omega1:
    start: 50
    stop: 500
    num: 9
  c:
    values:
      - 3
      - 5
integrate:
  dt: 0.02
  transient: 200
  duration: 600
measures:
  lyapunov:
    exponents: 3
"""


def message(text: str, *change: str) -> str:
    """Return what is said of a config in which one text is replaced."""
    assert not change or change[0] in text
    with pytest.raises(ConfigError) as caught:
        parse_sweep(text.replace(*change, 1) if change else text, "x.yaml")
    assert str(caught.value).isprintable()
    return str(caught.value)


def test_the_base_is_a_config() -> None:
    assert parse_sweep(BLOCK).grid.shape == (9, 2)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("dt: 0.02", "dt: 700", "17: integrate.dt: a step of 700 is longer than integrate.duration (line 19)"),
        ("stop: 500", "stop: 50", "9: axes.Omega1.start: 50 is also the value of axes.Omega1.stop (line 10)"),
        ("stop: 500", "stop: -1", "10: axes.Omega1.stop: -1 rad/s is outside the domain"),
        (
            "start: 50\n",
            "start: 0\n    spacing: log\n",
            "9: axes.Omega1.start: 0 cannot be on a logarithmic axis, axes.Omega1.spacing (line 10)",
        ),
        ("num: 9", "values: [1]", "9: axes.Omega1.start: cannot stand beside axes.Omega1.values (line 11)"),
        ("values:", "num: 3\n    values:", "13: axes.c.num: cannot stand beside axes.c.values (line 14)"),
        ("- 5", "- 3", "15: axes.c.values (item 2): 3 is given twice; it is axes.c.values (item 1) (line 14) already"),
        ("    stop: 500\n", "", "8: axes.Omega1.stop: is missing"),
        (
            "    start: 50\n    stop: 500\n    num: 9\n",
            "    {}\n",
            "8: axes.Omega1.values: is missing, and so are start, stop, num",
        ),
        ("  p: 0.001\n", "", "3: initial.p: is missing; give it here, or vary it as axes.p in axes (line 6)"),
        ("  p: 0.001\n  q: 0.001\n", "", "3: initial.p: is missing, so is q"),
        ("initial:\n  p: 0.001\n  q: 0.001\n  r: 0.001\n", "", "1: initial: is missing; give p, q, r"),
        ("initial:", "parameters: {c: 5}\ninitial:", "3: parameters.c: is fixed here and varied in axes.c (line 13)"),
        ("dt: 0.02", "dt: 1e-320", "19: integrate.duration: 600 is more than 9e15 steps of integrate.dt (line 17)"),
        ("transient: 200", "transient: 1e300", "18: integrate.transient: 1e+300 is more than 9e15 steps"),
        (
            "transient: 200",
            "transient: 200\n  segment: 1e9",
            "19: integrate.segment: 1e+09 is longer than integrate.transient (line 18) + integrate.duration (line 20)",
        ),
        ("exponents: 3", "batch: 801", "22: measures.lyapunov.batch: 801 is longer than"),
        (
            "exponents: 3",
            "block: 50000",
            "22: measures.lyapunov.block: 50000 steps of 0.02, integrate.dt (line 17), are longer than",
        ),
        ("dt: 0.02", "dt: 50", "17: integrate.dt: 25 steps of 50, measures.lyapunov.block, are longer than"),
        (
            "transient: 200",
            "transient: 1e9\n  segment: 1",
            "18: integrate.transient: 1e+09 with integrate.segment (line 19) makes",
        ),
        (
            "duration: 600",
            "duration: '400,5'",
            "19: integrate.duration: '400,5' is not accepted; it should be a number above 0 (",
        ),
        ("duration: 600", "duration: 6_00", "19: integrate.duration: '6_00' is not accepted"),
        (
            "num: 9",
            "num: 1e6",
            "11: axes.Omega1.num: 1e6 is not accepted; it should be a whole number from 1 to 1000000",
        ),
        ("num: 9", "num:", "11: axes.Omega1.num: is missing"),
        ("num: 9", f"num: {10**18}", "11: axes.Omega1.num: 1000000000000000000 is not accepted"),
        ("stop: 500", "stop: " + "9" * 400, "10: axes.Omega1.stop: 9999999999"),
        ("stop: 500", "stop: " + "9" * 5000, "10: axes.Omega1.stop: 9999999999... has 5000 characters"),
        ("stop: 500", "stop: -1.7e308", "10: axes.Omega1.stop: -1.7e+308 rad/s is outside the domain"),
    ],
)
def test_both_keys_are_told(old: str, new: str, says: str) -> None:
    assert message(BLOCK, old, new).startswith(f"x.yaml:{says}")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("p: 0.001", "p: &a 0.001", "4: initial.p: anchors and aliases are not allowed"),
        ("q: 0.001", "q: *a", "5: initial.q: anchors and aliases are not allowed"),
        ("p: 0.001", "p: !!float 1", "4: initial.p: tags are not allowed"),
        ("p: 0.001", "p: !x!y 1", "4: initial.p: tags are not allowed"),
        ("p: 0.001", "p: 1\n  p: 2", "5: initial.p: duplicate key; it is given on line 4 already"),
        ("p: 0.001", "<<: {p: 1}", "4: initial.<<: merging mappings is not allowed"),
        ("p: 0.001", "p: " + "{a: " * 30 + "}" * 30, "4: initial.p.a.a"),
        ("p: 0.001", "p: '0.001", "4: initial.p: its quotation mark is not closed before line"),
        ("p: 0.001", "p: [0.001", "4: initial.p: its [ is not closed by ] before line 5"),
        ("p: 0.001", "p: {0.001", "4: initial.p: its { is not closed by } before line 5"),
        ("p: 0.001", "p 0.001", "4: initial.p: has no ': ' after it"),
        ("p: 0.001", "p:0.001", "4: initial.p: has no ': ' after it"),
        ("Omega1:\n", "Omega1\n", "8: axes.Omega1: has no ': ' after it"),
        ("stop: 500", " stop: 500", "10: axes.Omega1.stop: is indented further than axes.Omega1.start (line 9)"),
        (
            "    stop: 500",
            "   stop: 500",
            "10: axes.stop: is not indented like axes.Omega1 (line 8) or axes.Omega1.start (line 9)",
        ),
        ("    stop: 500", "\tstop: 500", "10: axes.Omega1.stop: a tab stands where only spaces may"),
        ("stop: 500", "stop: 500: 3", "10: axes.Omega1.stop: a second ':' is not allowed here"),
        ("stop: 500", "stop: @500", "10: axes.Omega1.stop: '@' cannot begin a value; put the value in quotes"),
        ("stop: 500", "stop: - 500", "10: axes.Omega1.stop: a list cannot begin here"),
        ("stop: 500", 'stop: "\\q"', "10: axes.Omega1.stop: 'q' is not known after a \\"),
        ("stop: 500", "stop: 5\x0700", "10: axes.Omega1.stop: the character U+0007 is not allowed"),
        ("stop: 500", "st\x00op: 500", "10: axes.Omega1.stop: the character U+0000 is not allowed"),
        ("stop: 500", "stop: 500 # \x1b[31m", "10: axes.Omega1.stop: the character U+001B is not allowed"),
        ("stop: 500", "[stop]: 500", "10: axes.Omega1: a key here is a list or a mapping"),
        ("stop: 500", "'stop\\n': 500", "10: axes.Omega1.stop\\n: unknown key"),
        ("stop: 500", '"st\\nop": 500', "10: axes.Omega1.'st\\nop': unknown key"),
        ("model: quad", "---\nmodel: quad", "2: a second document begins here"),
    ],
)
def test_what_is_no_yaml_is_told_by_its_key(old: str, new: str, says: str) -> None:
    assert message(BLOCK, old, new).startswith(f"x.yaml:{says}")


def test_bytes_that_are_no_text_are_told_by_their_key() -> None:
    with pytest.raises(ConfigError, match=r"^x.yaml:2: model: the byte 0xe9 is not UTF-8 text$"):
        parse_sweep(BLOCK.encode().replace(b"quadrotor", b"quadr\xe9"), "x.yaml")


def test_a_byte_order_mark_and_windows_line_ends_are_fine() -> None:
    assert parse_sweep(b"\xef\xbb\xbf" + BLOCK.replace("\n", "\r\n").encode()).grid.shape == (9, 2)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{name: a, initial: {x: 1}, y: 1, z: 1}, model: lorenz}", "initial.x"),
        ("{name: a,\n initial: {x: {a: 1, y: 1},\n model: lorenz}", "initial.x"),
        ("{name: a,\n initial: {x: 1, y: 1,\n axes: {rho: {values: [1]}},\n model: lorenz}", "initial"),
        ("name: a\nmodel: lorenz\naxes:\nrho:\n  values: [1]\n", "rho"),
    ],
)
def test_the_reason_of_a_wrong_bracket_is_told(text: str, says: str) -> None:
    assert re.match(rf"x.yaml:\d: {re.escape(says)}\b", message(text))


@pytest.mark.parametrize(
    ("word", "value"),
    [
        *(("", None), ("~", None), ("Null", None), ("true", True), ("FALSE", False), ("no", "no"), ("1_000", "1_000")),
        *(
            ("010", 10),
            ("0o17", 15),
            ("0x1f", 31),
            ("-7", -7),
            ("1e-3", 1e-3),
            (".5", 0.5),
            ("5.", 5.0),
            ("1.e2", 100.0),
        ),
        *(
            ("-.inf", -math.inf),
            ("+.INF", math.inf),
            ("2001-01-01", "2001-01-01"),
            ("1e", "1e"),
            ("0b1", "0b1"),
            ("=", "="),
        ),
        *(("1:30", "1:30"), ("nan", "nan"), ("inf", "inf"), ("1e999", math.inf)),
    ],
)
def test_words_mean_what_yaml_1_2_says(word: str, value: object) -> None:
    assert scalar(word) == value
    assert type(scalar(word)) is type(value)
    assert np.isnan(scalar(".NaN"))


@pytest.mark.parametrize(
    ("axes", "share"),
    [
        ("Ix: {start: 1e-5, stop: 2e-2, num: 2001}", ""),
        ("Ix: {start: 1e-5, stop: 2e-2, num: 1500}, Iy: {start: 1e-5, stop: 2e-2, num: 2000}, c: {values: [1, 2]}", ""),
        ("Ix: {start: 1e-5, stop: 2e-2, num: 3000}, Iy: {start: 1e-5, stop: 2e-2, num: 3000}", "about "),
    ],
)
def test_the_share_of_cells_without_a_body_is_exact(axes: str, share: str) -> None:
    sweep = parse_sweep(re.sub(r"axes:\n(?:  .*\n)+", f"axes: {{{axes}}}\n", BLOCK))
    values = {axis.name: np.asarray(axis.values) for axis in sweep.grid.axes}
    Ix, Iy = np.meshgrid(values["Ix"], values.get("Iy", 9.8e-3), sparse=True)
    broken = 100 * np.mean(Ix > Iy + 8.8e-3)
    said = next(warning for warning in sweep.warnings if warning.startswith("Ix <="))
    number = float(re.search(rf"in {share}([0-9.]+) % of the cells", said)[1])  # type: ignore[index]
    assert number == (pytest.approx(broken, rel=5e-3) if share else float(f"{broken:.3g}"))


def test_axes_that_are_too_large_are_refused_before_they_are_made() -> None:
    large = "{start: 1, stop: 2, num: 1000000}"
    axes = f"axes: {{Omega1: {large}, c: {large}, Ix: {{values: [1, 2]}}}}\n"
    text = re.sub(r"axes:\n(?:  .*\n)+", axes, BLOCK)
    assert message(text).startswith(
        "x.yaml:7: axes.Omega1.num: 1000000 values, with axes.c.num and axes.Ix.values, make 2e+12"
    )


@pytest.mark.parametrize("text", ["dt: 0,005", "dt: 0,02", "duration: 400,5", "transient: 0,5"])
def test_a_decimal_comma_is_recognised(text: str) -> None:
    key = text.split(":", maxsplit=1)[0]
    broken = re.sub(rf"{key}: [\d.]+", text, YAW)
    with pytest.raises(ConfigError, match=rf"integrate.{key}: {text.split()[1]} is not accepted.*with a point"):
        parse_sweep(broken)
