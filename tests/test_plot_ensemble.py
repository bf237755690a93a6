"""Figures of ensembles and basins: survival, lifetimes, shares, attractors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm, to_rgb

from quavsweep.config import parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.plot import make_figure
from quavsweep.plot.attractor import COLOURS
from quavsweep.result import open_result
from quavsweep.sweep import run_sweep
from tests.plot_runs import MAP, changed, legend_texts, run

LIFETIME = """
name: lifetime
model: lorenz
axes:
  rho: {values: [20, 22, 28]}
  ensemble: {num: 128, seed: 1, box: {x: [-20, 20], y: [-20, 20], z: [5, 45]}}
integrate: {method: rk4, dt: 0.01, duration: 300, segment: 10}
"""
PLANE = LIFETIME.replace("rho: {values: [20, 22, 28]}", "rho: {values: [20, 22, 28]}\n  sigma: {values: [10, 11]}")
MANY = """
name: many
model: lorenz
axes:
  rho: {start: 28, stop: 35, num: 8}
  ensemble: {num: 12, seed: 1, box: {x: [-20, 20], y: [-20, 20], z: [5, 45]}}
integrate: {method: rk4, dt: 0.01, duration: 100, segment: 10}
"""
BASIN = """
name: basin
model: quadrotor_yaw
parameters: {Omega1: 100}
initial: {q: 0.1}
axes:
  p: {start: -2, stop: 2, num: 6}
  r: {start: -4, stop: 6, num: 5}
integrate: {method: rk4, dt: 0.02, duration: 800, segment: 50}
"""


def test_lifetimes_have_bars_bounds_and_shares() -> None:
    figure = make_figure(run(LIFETIME))
    lifetime, chaotic, share = figure.axes[:3]
    assert lifetime.get_yscale() == "log"
    assert "mean lifetime of chaos" in lifetime.get_ylabel()
    assert legend_texts(lifetime) == ["mean \N{PLUS-MINUS SIGN} standard error", "at least (95 %)"]
    points = run(LIFETIME).points
    np.testing.assert_array_equal(lifetime.lines[0].get_ydata(), points["lifetime"])
    np.testing.assert_array_equal(chaotic.lines[0].get_ydata(), points["chaotic_share"])
    assert share.get_ylim() == (-0.03, 1.03)
    assert "sink" in legend_texts(share)


def test_a_survival_is_a_falling_share_with_its_exponential() -> None:
    axes = make_figure(run(LIFETIME), variables=["survival"]).axes[0]
    assert axes.get_yscale() == "log"
    assert axes.get_legend().get_title().get_text().startswith("mean lifetime of chaos")
    texts = legend_texts(axes)
    assert texts[0].startswith(r"$\rho = 22$: $")
    assert texts[1].startswith(r"$\rho = 28$: $> ")
    solid, dashed = axes.lines[:2]
    share = solid.get_ydata()
    assert share[0] == 1
    assert (np.diff(share[np.isfinite(share)]) <= 0).all()
    assert dashed.get_xdata()[0] == run(LIFETIME)["lifetime_after"][1]


def test_a_survival_says_which_points_it_shows_and_steps_where_it_is_looked_at() -> None:
    axes = make_figure(run(LIFETIME), variables=["survival"]).axes[0]
    title = axes.get_legend().get_title().get_text()
    assert title == "mean lifetime of chaos, 2 of 3 points:\nthose with $\\geq 10$ starts beyond $t_0$"
    assert axes.lines[0].get_drawstyle() == "steps-post"
    many = run(MANY)
    assert (many["chaotic_share"] * 12 >= 10).all()
    axes = make_figure(many, variables=["survival"]).axes[0]
    title = axes.get_legend().get_title().get_text()
    assert title == "mean lifetime of chaos, 6 of 8 points:\nevenly chosen"
    assert len(axes.lines) == 6


def test_bounds_stand_in_where_no_lifetime_is_known() -> None:
    line = make_figure(run(MANY)).axes[0]
    assert legend_texts(line) == ["at least (95 %)"]
    result = run(MANY.replace("rho: {", "sigma: {values: [10, 11]}\n  rho: {"))
    assert np.isnan(result["lifetime"]).all()
    figure = make_figure(result)
    axes = figure.axes[0]
    mesh = [c for c in axes.collections if isinstance(c, QuadMesh)][-1]
    np.testing.assert_allclose(np.ma.getdata(mesh.get_array()).reshape(8, 2).T, result["lifetime_at_least"])
    assert isinstance(mesh.norm, LogNorm)
    assert legend_texts(axes) == ["at least"]
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert any(label.startswith("mean lifetime of chaos") for label in labels)
    assert not any("relative" in label for label in labels)


def test_lifetimes_of_several_runs_are_compared() -> None:
    lines = make_figure([run(LIFETIME), run(LIFETIME, "other")])
    assert [axes.get_title() for axes in lines.axes[:2]] == ["result", "other"]
    assert all(axes.get_ylabel().startswith("mean lifetime") for axes in lines.axes[:2])
    maps = make_figure([run(PLANE), run(PLANE, "other")])
    assert maps.axes[-1].get_ylabel().startswith("mean lifetime")


def test_a_figure_at_a_horizon_says_so(tmp_path: Path) -> None:
    run_sweep(parse_sweep(LIFETIME), tmp_path)
    seen = open_result(tmp_path, 150)
    for figure in (make_figure(seen), make_figure(seen, variables=["survival"])):
        assert figure.get_suptitle() == "horizon $150$; chaos there is undecided"
    assert make_figure(seen.at(ensemble=3)).get_suptitle().endswith("horizon $150$; chaos there is undecided")
    cell = make_figure(seen.at(ensemble=3, rho=20)).get_suptitle()
    assert cell.endswith("horizon $150$; chaos there is undecided")
    titles = [axes.get_title() for axes in make_figure([seen, run(LIFETIME)]).axes[:2]]
    assert titles == ["lifetime,\nhorizon $150$; chaos there is undecided", "result"]
    assert make_figure(run(LIFETIME)).get_suptitle() == ""
    whole = open_result(tmp_path, 300)
    assert make_figure(whole).get_suptitle() == "horizon $300$"
    np.testing.assert_array_equal(whole["region"], run(LIFETIME)["region"])


def test_survival_of_one_point_is_its_natural_figure() -> None:
    axes = make_figure(run(LIFETIME).at(rho=22)).axes[0]
    assert axes.get_ylabel() == "share of starts that have not settled"


def test_survival_needs_an_ensemble() -> None:
    with pytest.raises(ConfigError, match="survival needs an ensemble of starts"):
        make_figure(run(MAP), variables=["survival"])


def test_a_map_of_lifetimes_is_logarithmic_and_marks_bounds() -> None:
    result = run(PLANE)
    figure = make_figure(result)
    axes = figure.axes[0]
    mesh = [c for c in axes.collections if isinstance(c, QuadMesh)][-1]
    assert isinstance(mesh.norm, LogNorm)
    assert axes.lines[0].get_xdata().tolist() == [28, 28]
    assert "at least" in legend_texts(axes)
    chaotic = figure.axes[2]
    assert [c for c in chaotic.collections if isinstance(c, QuadMesh)][-1].norm.vmax == 1


def test_a_config_says_what_its_figure_shows() -> None:
    result = run(PLANE + "plot: [basin_share.sink, attractor_share.2]\n")
    labels = [axes.get_ylabel() for axes in make_figure(result).axes[2:]]
    assert labels == ["share of starts: sink", "share of starts: attractor 2"]
    assert "plot" not in result.stored.file_attributes["config"]


def test_a_basin_has_a_colour_for_each_attractor() -> None:
    result = run(BASIN)
    axes = make_figure(result).axes[0]
    texts = legend_texts(axes)
    assert texts[0].startswith("sink at $(p, q, r) = ({-0.423}, {-0.994}, {0.444})")
    assert texts[1].startswith("sink at $(p, q, r) = ({0.423}, {0.994}, {0.444})")
    mesh = [c for c in axes.collections if isinstance(c, QuadMesh)][-1]
    for i in range(2):
        np.testing.assert_allclose(mesh.to_rgba(np.array([i + 1]))[0, :3], to_rgb(COLOURS[i]), atol=1 / 255)


def test_a_start_without_attractor_shows_its_region() -> None:
    result = run(BASIN)
    attractor, region = result["attractor"].copy(), result["region"].copy()
    attractor[0, 0], region[0, 0] = 0, 4
    assert "chaos" in legend_texts(make_figure(changed(result, attractor=attractor, region=region)).axes[0])
