"""Figures of ensembles and basins: survival, lifetimes, shares, attractors."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm, to_rgb

from quavsweep.errors import ConfigError
from quavsweep.plot import make_figure
from quavsweep.plot.attractor import COLOURS
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
    assert axes.get_legend().get_title().get_text() == "mean lifetime of chaos"
    texts = legend_texts(axes)
    assert texts[0].startswith(r"$\rho = 22$: $")
    assert texts[1].startswith(r"$\rho = 28$: $> ")
    solid, dashed = axes.lines[:2]
    share = solid.get_ydata()
    assert share[0] == 1
    assert (np.diff(share[np.isfinite(share)]) <= 0).all()
    assert dashed.get_xdata()[0] == run(LIFETIME)["lifetime_after"][1]


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
