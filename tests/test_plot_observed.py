"""Figures of observables: computed when drawn, from stored states and each cell's parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from quavsweep.codes import Region
from quavsweep.config import parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.kernels.observe import observe
from quavsweep.plot import make_figure
from quavsweep.plot.catalogue import Catalogue
from quavsweep.plot.point import make_point_figure
from quavsweep.point import compute_point
from quavsweep.result import Result, open_result
from quavsweep.sweep import run_sweep

DIAGRAM = """
name: diagram
model: quadrotor_yaw
initial: {p: 0.001, q: 0.001, r: 0.001}
axes: {Omega1: {values: [30, 260]}}
integrate: {method: rk4, dt: 0.02, transient: 400, duration: 400}
measures: {samples: {maxima: casimir_power, max: 20}, orbit: {every: 1}}
"""


@pytest.fixture(scope="module")
def diagram(tmp_path_factory: pytest.TempPathFactory) -> Result:
    folder = tmp_path_factory.mktemp("diagram")
    run_sweep(parse_sweep(DIAGRAM), folder)
    return open_result(folder)


def test_samples_and_final_states_have_observables(diagram: Result) -> None:
    catalogue = Catalogue(diagram, samples=True)
    defaults = diagram.sweep.model.defaults
    for name in ("samples", "final_state"):
        found = catalogue.find(f"{name}.casimir_power")
        assert found.unit == "W"
        for cell, speed in enumerate((30.0, 260.0)):
            p = defaults | {"Omega1": speed}
            expected = observe(diagram.sweep.model, ["casimir_power"], diagram[name][cell], p)[..., 0]
            np.testing.assert_array_equal(found.values[cell], expected)
    assert len(catalogue.parts("final_state")) == 3
    with pytest.raises(ConfigError, match=r"did you mean samples.casimir_power"):
        catalogue.find("samples.casimir_powr")


def test_a_sink_is_drawn_at_the_power_of_its_equilibrium(diagram: Result) -> None:
    assert diagram["region"].tolist() == [Region.SINK, Region.PERIODIC]
    figure = make_figure(diagram, variables=["samples.casimir_power"])
    x, y = figure.axes[0].lines[0].get_data()
    assert np.abs(np.asarray(y)[np.asarray(x) == 30.0]).max() < 1e-15
    assert np.nanmin(np.asarray(y)[np.asarray(x) == 260.0]) > 0.01
    assert "W" in figure.axes[0].get_ylabel()


def test_a_single_orbit_shows_observables_where_asked_for(diagram: Result, tmp_path: Path) -> None:
    single = diagram.at(Omega1=260)
    axes = make_figure(single, variables=["orbit.casimir_power"]).axes[0]
    drawn = np.concatenate([line.get_ydata() for line in axes.lines[:2]])  # type: ignore[arg-type]
    p = diagram.sweep.model.defaults | {"Omega1": 260.0}
    assert set(drawn) <= set(observe(diagram.sweep.model, ["casimir_power"], single["orbit"], p)[:, 0])
    with pytest.raises(ConfigError, match=r"orbit.casimir_power"):
        make_figure(single, variables=["orbit.power"])


def test_a_point_shows_what_is_asked_for() -> None:
    point = compute_point(parse_sweep(DIAGRAM), {"Omega1": 260})
    plain, more = make_point_figure(point), make_point_figure(point, ["orbit.casimir_power"])
    assert len(more.axes) == len(plain.axes) + 1
    with pytest.raises(ConfigError, match=r"did you mean orbit\.casimir_power"):
        make_point_figure(point, ["orbit.casimir_powers"])
