"""The README: every command and example in it is run as written, on thumbnails of the shipped configs."""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.catalogue import select
from quavsweep.config import parse_sweep
from quavsweep.kernels.derive import derive
from quavsweep.models import NAMES
from quavsweep.models.user import read_model

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
SETUP = re.compile(r"<!-- (?:first|test) command -->\n```sh\n.*?```", re.DOTALL)
# Fewer values per axis; nothing else is changed.
FEWER = "451:16 201:9 1117:24 1024:32 56:3 60:3 40}:3} 256:16 400:6 91:4 41}:3} 200,:16,"
THUMBNAILS = {f"num: {number}": f"num: {few}" for number, few in (pair.split(":") for pair in FEWER.split())}


def _blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", SETUP.sub("", README), re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the shipped configs on thumbnail grids."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "configs", folder / "configs")
    for path in (folder / "configs").rglob("*.yaml"):
        text = path.read_text()
        for number, fewer in THUMBNAILS.items():
            text = text.replace(number, fewer)
        path.write_text(text)
    (folder / "my_model.py").write_text(_model())
    (folder / "my_config.yaml").write_text(next(text for text in _blocks("yaml") if "driven_pendulum" in text))
    return folder


def _model() -> str:
    (text,) = (block for block in _blocks("python") if "MODEL = Model(" in block)
    return text


@pytest.mark.timeout(600)
def test_every_command_works_as_written(folder: Path) -> None:
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    commands = [line for block in _blocks("sh") for line in block.splitlines() if line.strip()]
    assert len(commands) > 15
    for written in commands:
        command = re.sub(r"quavsweep paper(?= +#)", "quavsweep paper --quick", written)  # else a quarter of an hour
        done = subprocess.run(
            ["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
        assert "Traceback" not in done.stderr, command
        assert all(len(line) <= 80 for line in done.stdout.splitlines()) or "help" in command, command
    for name in ("results/omega_c/map.png", "results/omega_c/point.png", "results/omega_c/settle.pdf", "line.png"):
        assert (folder / name).stat().st_size > 3000, name


def test_the_examples_in_python_work_as_written(folder: Path) -> None:
    pytest.importorskip("xarray")
    scripts = [block for block in _blocks("python") if "import quavsweep\n" in block]
    assert scripts
    for script in scripts:
        done = subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def test_the_example_of_a_model_is_one(tmp_path: Path) -> None:
    path = tmp_path / "my_model.py"
    path.write_text(_model())
    assert len(_model().splitlines()) <= 22
    model = read_model(path)
    program = derive(model)
    given = program.names(
        (1.0, 2.0), program.coefficient_values([np.array([x]) for x in (0.5, 1.15, 2 / 3)])[:, 0], 0.3
    )
    damped = 1.15 * math.cos(0.2) - 1.0 - math.sin(1.0)
    assert program.evaluate(program.rhs, given) == pytest.approx([2.0, damped])


def test_the_examples_of_configs_are_some(folder: Path) -> None:
    for text in _blocks("yaml"):
        model = read_model(folder / "my_model.py") if "driven_pendulum" in text else None
        assert model or not parse_sweep(text, model=model).warnings  # dt is rounded to a part of the forcing period


def _commands_in_tables() -> list[str]:
    rows = [line for line in README.splitlines() if line.startswith("|")]
    return [text for row in rows for text in re.findall(r"`([^`]+)`", row) if text.startswith(("pytest", "python"))]


def test_commands_in_tables_name_tests_and_benchmarks_that_are_there() -> None:
    commands = _commands_in_tables()
    assert len(commands) >= 6
    for command in commands:
        if command.startswith("pytest"):
            words = [sys.executable, "-m", *command.split(), "--collect-only"]
            done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
            assert done.returncode == 0, command + done.stdout


def test_benchmarks_in_tables_are_rows() -> None:
    named = [command.split()[3:] for command in _commands_in_tables() if command.startswith("python -m benchmarks")]
    assert len(named) > 10
    for names in named:
        assert select(names)


def test_setting_up_is_tested_on_every_push() -> None:
    script = (ROOT / ".ci" / "run").read_text()
    for name in ("first command", "test command"):
        assert f"<!-- {name} -->" in README
        assert name in script


def test_pictures_and_models_that_are_named_exist() -> None:
    for picture in re.findall(r"!\[.*?\]\((.*?)\)", README):
        assert (ROOT / picture).is_file(), picture
    for name in NAMES:
        assert f"`{name}`" in README
