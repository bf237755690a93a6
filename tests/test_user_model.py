"""A user's model: twenty lines in a file, readers that need no code, and mistakes told with their line."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from quavsweep.codes import Region, Status
from quavsweep.config import load_sweep, parse_sweep
from quavsweep.config.model import own_model
from quavsweep.config.template import make_template
from quavsweep.errors import ConfigError, DamageError, ModelError
from quavsweep.kernels.described import DescribedModel
from quavsweep.kernels.description import describe_model, read_description
from quavsweep.kernels.lookup import make_program
from quavsweep.models import Model, Parameter, Relation, Section, State, load_model
from quavsweep.models.user import read_model
from quavsweep.overview import Lookout
from quavsweep.plot import draw
from quavsweep.point import compute_point
from quavsweep.provenance import identify
from quavsweep.result import open_result
from quavsweep.sweep import extend_sweep, reclassify, run_sweep
from quavsweep.verify import verify_folder

PENDULUM = '''"""A pendulum that is driven by a periodic torque."""

from math import pi

from quavsweep.models import Model, Parameter, State
from quavsweep.models.function import cos, sin


def rhs(t, theta, w, damping, drive, omega):
    return w, drive * cos(omega * t) - damping * w - sin(theta)


MODEL = Model(
    name="driven_pendulum",
    rhs=rhs,
    states=(State("theta", "rad", circle=2 * pi), State("w")),
    parameters=(Parameter("damping", 0.5), Parameter("drive", 1.15), Parameter("omega", 2 / 3)),
    forcing_period=lambda omega: 2 * pi / omega,
)
'''
CONFIG = """
name: pendulum
model: driven_pendulum
initial: {theta: 0.2, w: 0}
axes:
  drive: {values: [0.0, 0.9, 1.15, 1.35]}
integrate: {dt: 0.05, transient: 500, duration: 1500}
measures: {lyapunov: {exponents: 2, block: 10}}
"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    model, config = tmp_path / "my_model.py", tmp_path / "my_config.yaml"
    model.write_text(PENDULUM)
    config.write_text(CONFIG)
    return model, config


def test_a_forced_oscillator_rests_cycles_and_is_chaotic(files: tuple[Path, Path], tmp_path: Path) -> None:
    model, config = files
    out = tmp_path / "run"
    path = run_sweep(load_sweep(config, model=model), out)
    model.unlink()  # from here on nobody can run it
    result = open_result(out)
    expected = [Status.ENDED_SINK, Status.ENDED_CYCLE, Status.TIME_OVER, Status.ENDED_CYCLE]
    np.testing.assert_array_equal(result["status"], expected)
    regions = [Region.SINK, Region.PERIODIC, Region.CHAOS, Region.PERIODIC]
    np.testing.assert_array_equal(result["region"], regions)
    np.testing.assert_allclose(result["period"][[1, 3]], 3 * np.pi)
    np.testing.assert_allclose(result["lyapunov"][[1, 3]].sum(axis=1), -0.5)
    np.testing.assert_allclose(result["lyapunov"][0], -0.25)  # a spiral: half the damping
    np.testing.assert_allclose(result["lyapunov_raw"][2].sum(), -0.5, atol=1e-6)
    assert isinstance(result.sweep.model, DescribedModel)
    assert (out / "model.py").read_text() == PENDULUM
    assert Lookout.of(out).look().complete
    assert not verify_folder(out).damaged
    assert draw(result, tmp_path / "map.png").is_file()
    before = path.read_bytes()
    assert reclassify(out).read_bytes() == before
    alone = tmp_path / "alone.h5"
    shutil.copy(path, alone)
    np.testing.assert_array_equal(open_result(alone)["status"], expected)
    for integrate in (
        lambda: compute_point(result.sweep, {"drive": 0.9}),
        lambda: extend_sweep(out, 3000),
        lambda: run_sweep(load_sweep(out / "config.yaml"), tmp_path / "again"),
    ):
        with pytest.raises(ModelError, match=r"equations of driven_pendulum are needed.*--model FILE"):
            integrate()


def test_described_and_live_models_have_the_same_identity(files: tuple[Path, Path]) -> None:
    model, config = files
    live = load_sweep(config, model=model)
    described = parse_sweep(CONFIG, model=read_description(describe_model(live.model)))
    assert identify(described) == identify(live)
    assert described.clock == live.clock
    assert describe_model(described.model) == describe_model(live.model)


def test_a_model_object_is_taken_as_it_is() -> None:
    def rhs(x, rate):  # type: ignore[no-untyped-def]
        return (-rate * x,)

    model = Model(
        "decay",
        rhs,
        (State("x"),),
        (Parameter("rate", 1, low=0),),
        relations=(Relation("rate < 9", lambda rate: rate < 9, "too fast"),),
        section=Section("x", 0),
        symmetries=((-1,),),
    )
    text = "name: a\nmodel: decay\ninitial: {x: 1}\nintegrate: {dt: 0.1, duration: 10}\nparameters: {rate: 10}"
    sweep = parse_sweep(text, model=model)
    assert any("rate < 9 does not hold" in warning for warning in sweep.warnings)
    again = read_description(describe_model(model))
    assert (again.states, again.parameters, again.section) == (model.states, model.parameters, model.section)
    assert again.symmetries == model.symmetries
    assert make_program(again) == make_program(model)


def test_a_template_of_a_users_model_is_read(files: tuple[Path, Path]) -> None:
    model = read_model(files[0])
    sweep = parse_sweep(make_template(model, "mine"), model=model)
    assert sweep.grid.shape == (11,)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            "return w, drive",
            "return drive",
            r":10: the equations return a single value; they return the derivatives of",
        ),
        (
            "return w, ",
            "return (w,) #",
            r":10: the equations return 1 derivatives for 2 states, so w has no derivative",
        ),
        ("return w, drive", "w, drive", r":9: the equations return None; they return the derivatives of theta, w"),
        ("- damping * w", "- dampin * w", r":10: name 'dampin' is not defined"),
        (
            "    return w",
            "    if w > 0:\n        w = 2 * w\n    return w",
            r":10: `if`, .* decides by a state or param",
        ),
        ("    return w", "    w = max(w, 0)\n    return w", r":10: `if`, `min`, `max` .*; use where, minimum"),
        (
            "    return w",
            "    a = 1\n    b = theta / 0\n    return b + w",
            r":11: zoo, a division by zero, is not a finite",
        ),
        ("return w, ", "return abs(theta) ** 1.3, ", r":10: the power 1.3 cannot be compiled; multiples of 1/2"),
        ("    return w", "    w = theta**w\n    drive = 1\n    return w", r":10: the power .* cannot be compiled"),
        ("2 * pi / omega,", "2 * pi / omega**1.3,", r":18: the power -1.3 cannot be compiled"),
        ("sin(theta)\n", "math.sin(theta)\n", r":10: name 'math' is not defined"),
        (
            "import cos, sin",
            "import cos\nfrom math import sin",
            r":11: a function that takes only numbers got a state or parameter .*quavsweep.models.function",
        ),
        ("import cos, sin", "import cos, sine", r":6: cannot import name 'sine'|:6: ImportError"),
        (
            "rhs(t, theta, w, damping",
            "rhs(theta, w, damping",
            r":9: the system is forced, so its equations take t first",
        ),
        (
            "rhs(t, theta, w, damping",
            "rhs(t, theta, damping",
            r":9: the equations take .* but the model declares t, theta",
        ),
        (
            "    forcing_period=lambda omega: 2 * pi / omega,\n",
            "",
            r":9: the equations take t, but .* no forcing_period",
        ),
        ("lambda omega", "lambda speed", r":18: forcing_period takes speed, which is no parameter"),
        ("2 * pi / omega,", "2 * pie / omega,", r":18: name 'pie' is not defined"),
        (
            "lambda omega: 2 * pi",
            "lambda omega: 3 * pi",
            "the equations do not repeat themselves after the forcing_period",
        ),
        (
            "forcing_period=lambda omega: 2 * pi / omega",
            "forcing_period=6",
            r":13: forcing_period is 6, which is no func",
        ),
        ('Parameter("drive", 1.15)', 'Parameter("drive", -1, low=0)', r":13: the default -1 of drive is not possible"),
        ("    rhs=rhs,", "    rhs=rhs,\n    source='a\\nb',", r"source: .*texts have one line"),
        ("    states=(State(", "    states=(9, State(", r":13: .*'int' object has no attribute 'name'"),
        ("def rhs(t", "def rhs(t t", r":9: cannot be read: .*"),
        ("MODEL = Model(", "MODELS = Model(", r": makes no MODEL; it must say MODEL = Model"),
        ('name="driven_pendulum"', 'name="lorenz"', r"the catalogue has a model lorenz already"),
        ('name="driven_pendulum"', 'name="my model"', r":13: 'my model' cannot be the name of a model"),
        ('State("w")', 'State("region")', r":13: the name region is taken"),
        ('State("w")', 'State("w", color=1)', r":16: TypeError: .*color"),
    ],
)
def test_mistakes_are_told_with_their_line(files: tuple[Path, Path], old: str, new: str, says: str) -> None:
    path, config = files
    assert old in PENDULUM
    path.write_text(PENDULUM.replace(old, new))
    with pytest.raises((ModelError, ConfigError), match=says) as caught:
        load_sweep(config, model=path)
    assert caught.value.exit_code == 2
    assert (
        "my_model.py" in str(caught.value) or "catalogue" in str(caught.value) or "driven_pendulum" in str(caught.value)
    )
    assert len(str(caught.value).splitlines()) == 1


def test_a_changed_file_is_another_model(files: tuple[Path, Path]) -> None:
    path, _ = files
    first = make_program(read_model(path))
    path.write_text(PENDULUM.replace("sin(theta)", "2 * sin(theta)"))
    assert make_program(read_model(path)) != first


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            CONFIG.replace("driven_pendulum", "pendulum"),
            r"model: 'pendulum' is not the model that is given; it is driven",
        ),
        (CONFIG.replace("driven_pendulum", "lorenz"), r"model: 'lorenz' is not the model that is given"),
    ],
)
def test_a_config_of_another_model_is_refused(files: tuple[Path, Path], text: str, says: str) -> None:
    files[1].write_text(text)
    with pytest.raises(ConfigError, match=says):
        load_sweep(files[1], model=files[0])


def test_without_its_file_a_model_is_not_known(files: tuple[Path, Path]) -> None:
    with pytest.raises(ConfigError, match=r"there is no model 'driven_pendulum'; .*--model FILE brings another"):
        load_sweep(files[1])


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    for path in (tmp_path / "none.py", tmp_path):
        with pytest.raises(ModelError, match="cannot be read"):
            read_model(path)
    (tmp_path / "binary.py").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelError, match="is no text"):
        read_model(tmp_path / "binary.py")


def _changed(data: dict, keys: tuple, value: object) -> str:  # type: ignore[type-arg]
    inner = data
    for key in keys[:-1]:
        inner = inner[key]
    inner[keys[-1]] = value
    return json.dumps(data)


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (("name",), "__import__('os')"),
        (("name",), "lorenz"),
        (("states", 0, "name"), "x; import os"),
        (("states", 0, "unit"), "rad\x1b[31m"),
        (("states", 0, "circle"), -1.0),
        (("parameters", 0, "default"), "1"),
        (("symmetries",), [[1]]),
        (("program", "states"), ["u_theta", "u_v"]),
        (("program", "states"), ["u_theta", ["u_w"]]),
        (("program", "assignments", 0, "target"), "c0\nimport os"),
        (("program", "assignments", 0, "operation"), "system"),
        (("program", "assignments", 0, "operation"), "sin"),
        (("program", "assignments", 0, "arguments"), ["open", 1.0]),
        (("program", "rhs"), ["u_w"]),
        (("program", "rhs", 0), "exec"),
        (("program", "rhs", 0), {"a": 1}),
        (("program", "jacobian"), []),
        (("program", "period"), "nothing"),
        (("program", "extra"), 1),
        (("extra",), 1),
    ],
)
def test_a_description_is_data_of_unknown_origin(files: tuple[Path, Path], keys: tuple, value: object) -> None:  # type: ignore[type-arg]
    data = json.loads(describe_model(read_model(files[0])))
    with pytest.raises(ValueError, match=r"."):
        read_description(_changed(data, keys, value))


@pytest.mark.parametrize("text", ["", "[]", "{}", "[" * 100_000, "null", "\x00"])
def test_what_is_no_description_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"."):
        read_description(text)
    (tmp_path / "config.yaml").write_text(CONFIG)
    (tmp_path / "model.json").write_text(text)
    with pytest.raises(DamageError, match=r"model.json: is not the description.*--model FILE"):
        load_sweep(tmp_path / "config.yaml")


def test_a_name_of_the_catalogue_is_the_catalogues() -> None:
    lorenz = load_model("lorenz")
    assert own_model(lorenz) is lorenz
    with pytest.raises(ConfigError, match="has a model lorenz already"):
        own_model(replace(lorenz, bound=2e5))


def _run(*words: str) -> tuple[int, str]:
    done = subprocess.run(
        [sys.executable, "-m", "quavsweep", *words], capture_output=True, text=True, timeout=200, check=False
    )
    return done.returncode, done.stdout + done.stderr


def test_verbs_take_a_users_model(files: tuple[Path, Path]) -> None:
    model, config = map(str, files)
    folder = str(files[0].parent / "run")
    common = ("--set", "integrate.duration=100", "--set", "integrate.transient=100", "--no-plot")
    code, text = _run("run", config, "--out", folder, *common)
    assert (code, "--model FILE" in text) == (2, True)
    assert _run("run", config, "--model", model, "--out", folder, *common)[0] == 0
    assert _run("status", folder)[0] == 0
    code, text = _run("point", folder, "drive=0.9", "--no-plot")
    assert (code, "--model FILE" in text) == (2, True)
    code, text = _run("point", folder, "drive=0.9", "--no-plot", "--model", model)
    assert (code, "equal to the bit" in text) == (0, True)
    code, text = _run("init", "--model", model, "--out", str(files[0].parent / "new.yaml"))
    assert (code, "--model" in text) == (0, True)
    assert _run("init", "lorenz", "--model", model)[0] == 2
