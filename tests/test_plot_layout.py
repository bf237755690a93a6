"""Figures are fit to publish: nothing overlaps or is cut, letters can be read, text stays text."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from quavsweep.plot import draw, make_figure, make_point_figure
from quavsweep.result import Result
from tests.conftest import LORENZ, YAW
from tests.plot_layout import overlaps, smallest
from tests.plot_runs import CELL, LINE, MAP, changed, run, unfinished
from tests.test_plot_cell import ORBIT, SINK
from tests.test_plot_overlay import LOG
from tests.test_plot_point import make_point

IX = YAW.replace("c: {start: 3, stop: 7, num: 5}", "Ix: {start: 3e-3, stop: 7e-3, num: 5, spacing: log}")
HOVERING = "2.9e-5*(2*Omega1**2 + 2*(Omega1+c)**2) = 0.468*9.81"


def _all_regions(result: Result) -> Result:
    return changed(result, region=np.resize(np.arange(8, dtype=np.int8), (9, 5)))


FIGURES: dict[str, Callable[[], Figure]] = {
    "map": lambda: make_figure(run(MAP)),
    "all regions": lambda: make_figure(_all_regions(run(MAP))),
    "small values": lambda: make_figure(run(IX)),
    "logarithmic map": lambda: make_figure(run(LOG)),
    "many panels": lambda: make_figure(
        run(MAP), variables=["status", "was_chaotic", "lyapunov_se.2", "final_state.p", "first_time"]
    ),
    "curves": lambda: make_figure(run(MAP), overlays=["hovering: " + HOVERING, HOVERING, "c = 5"]),
    "unfinished map": lambda: make_figure(unfinished(run(MAP), np.s_[3:5]), variables=["region", "settle_time"]),
    "nothing computed": lambda: make_figure(unfinished(run(MAP), np.s_[:])),
    "line": lambda: make_figure(run(LORENZ)),
    "logarithmic line": lambda: make_figure(run(LOG).at(sigma=10), overlays=["rho = 50"]),
    "orbit diagram": lambda: make_figure(run(LINE)),
    "panels of a line": lambda: make_figure(
        run(LINE), variables=["samples.y", "status", "final_state", "lyapunov", "sample_time"], overlays=["rho = 50"]
    ),
    "unfinished line": lambda: make_figure(unfinished(run(LINE), np.s_[:])),
    "maps": lambda: make_figure([run(MAP, "one"), run(IX, "two")]),
    "five maps": lambda: make_figure([run(MAP)] * 5, variables=["lyapunov"], overlays=["c = 5"]),
    "lines": lambda: make_figure([run(LINE), run(LORENZ)], variables=["lyapunov"], overlays=["rho = 50"]),
    "cells": lambda: make_figure([run(CELL), run(ORBIT), run(SINK)], variables=["lyapunov"]),
    "cell": lambda: make_figure(run(CELL)),
    "orbit": lambda: make_figure(run(ORBIT)),
    "orbit alone": lambda: make_figure(run(SINK), variables=["orbit"]),
    "exponents": lambda: make_figure(run(CELL), variables=["lyapunov"]),
    "all of a cell": lambda: make_figure(run(ORBIT), variables=["orbit", "samples", "lyapunov", "final_state"]),
    "numbers": lambda: make_figure(run(CELL), variables=["final_state"]),
}


@pytest.mark.parametrize("kind", FIGURES)
def test_nothing_overlaps_and_all_can_be_read(kind: str) -> None:
    figure = FIGURES[kind]()
    assert overlaps(figure) == []
    assert smallest(figure) >= 6
    assert figure.get_figwidth() in (3.5, 7.0)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 12])
def test_nothing_overlaps_for_any_number_of_states(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    figure = make_point_figure(make_point(count, monkeypatch))
    assert overlaps(figure) == []
    assert smallest(figure) >= 6
    assert figure.get_figwidth() == 7.0


def test_overlaps_are_found() -> None:
    figure = Figure()
    figure.text(0.5, 0.5, "one")
    figure.text(0.51, 0.5, "two")
    figure.text(0.99, 0.2, "cut off")
    assert overlaps(figure) == ["'one' and 'two'", "'cut off' outside"]


def test_text_stays_text(tmp_path: Path) -> None:
    assert b"/Type3" not in draw(run(MAP), tmp_path / "map.pdf").read_bytes()
    svg = draw(run(MAP), tmp_path / "map.svg").read_text()
    assert ">sink</text>" in svg


def test_importing_says_nothing_of_a_cache_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    home = str(tmp_path / "file" / "home")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("XDG_", "MPL"))} | {"HOME": home}
    command = [sys.executable, "-c", "import quavsweep.plot"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert logging.getLogger("matplotlib").level == logging.NOTSET
