"""Figures, by the data of their artists."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb

from quavsweep.codes import REGION, Region
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.plot import draw, make_figure
from quavsweep.plot.scale import axis_is_log, edges
from quavsweep.plot.style import label, unit_text
from quavsweep.result import Result, open_result
from quavsweep.store import Stored
from quavsweep.sweep import run_sweep
from tests.conftest import LORENZ, YAW


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return open_result(run_sweep(parse_sweep(YAW), tmp_path_factory.mktemp("run")))


def _meshes(result: Result) -> list[QuadMesh]:
    figure = make_figure(result)
    return [next(c for c in axes.collections if isinstance(c, QuadMesh)) for axes in figure.axes[:2]]


def test_a_map_shows_each_cell_where_it_lies(result: Result) -> None:
    regions, largest = _meshes(result)
    # The first axis of the sweep lies to the right, so the array is transposed: (5, 9) for 9 x 5 cells.
    np.testing.assert_array_equal(np.ma.getdata(regions.get_array()).reshape(5, 9), result["region"].T)
    np.testing.assert_array_equal(np.ma.getdata(largest.get_array()).reshape(5, 9), result["lyapunov"][..., 0].T)
    corners = regions.get_coordinates()
    assert corners[0, 0, 0] == pytest.approx(50 - 56.25 / 2)
    assert corners[-1, -1, 1] == pytest.approx(7.5)


def test_regions_have_the_colours_of_their_codes(result: Result) -> None:
    regions, _ = _meshes(result)
    for code in REGION:
        np.testing.assert_allclose(regions.to_rgba(np.array([code.number]))[0, :3], to_rgb(code.colour), atol=1 / 255)


def test_the_neutral_exponent_is_white(result: Result) -> None:
    _, largest = _meshes(result)
    assert min(largest.to_rgba(np.array([0.0]))[0, :3]) > 0.95
    below, above = largest.to_rgba(np.array([largest.norm.vmin, largest.norm.vmax]))
    assert below[2] > below[0]
    assert above[0] > above[2]


def test_legend_and_labels(result: Result) -> None:
    figure = make_figure(result)
    texts = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    present = [code.meaning for code in REGION if (result["region"] == code.number).any()]
    assert texts == present
    assert figure.axes[0].get_xlabel() == r"$\Omega_1$ ($\mathrm{rad}\,\mathrm{s}^{-1}$)"
    assert figure.axes[2].get_ylabel() == r"$\lambda_1$ ($\mathrm{s}^{-1}$)"


def test_cells_that_are_not_computed_are_hatched(result: Result) -> None:
    region = result["region"].copy()
    region[3:5] = Region.NONE
    unfinished = Result(
        result.sweep, Stored({**result.stored.data, "region": region}, *list(vars(result.stored).values())[1:])
    )
    figure = make_figure(unfinished)
    assert figure.axes[0].patch.get_hatch()
    assert figure.axes[0].get_legend().get_texts()[-1].get_text() == "not computed"
    assert np.ma.getmaskarray(_meshes(unfinished)[0].get_array()).sum() == 10


# What protanopes, deuteranopes and tritanopes see, on linear RGB (Machado, Oliveira, Fernandes 2009, severity 1).
_BLIND = {
    "nobody": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def _lab(colour: str, blindness: str) -> np.ndarray:
    """Return CIE L*a*b* of a colour as a reader with that deficiency sees it."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    xyz = _XYZ @ np.clip(np.array(_BLIND[blindness]) @ linear, 0, 1) / _XYZ.sum(axis=1)
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("blindness", _BLIND)
def test_region_colours_are_told_apart_by_colour_blind_readers(blindness: str) -> None:
    shown = [code for code in REGION if code.number != Region.NONE]
    for i, first in enumerate(shown):
        for second in shown[:i]:
            distance = np.linalg.norm(_lab(first.colour, blindness) - _lab(second.colour, blindness))
            assert distance > 20, (first.name, second.name)


def test_one_axis_is_a_line(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    line = open_result(run_sweep(make_sweep(LORENZ), tmp_path))
    axes = make_figure(line).axes[0]
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), line["lyapunov"][:, 0])
    assert axes.get_xlabel() == r"$\rho$"


def test_more_than_two_axes_are_too_many(tmp_path: Path) -> None:
    head, tail = YAW.split("axes:")[0], YAW.split("num: 5}\n")[1]
    axes = "{Ix: {values: [4e-3]}, Omega1: {values: [90]}, c: {values: [5]}}"
    result = open_result(run_sweep(parse_sweep(f"{head}axes: {axes}\n{tail}"), tmp_path))
    with pytest.raises(ConfigError, match=r"at most two axes, this sweep has 3: Ix, Omega1, c; .* --at KEY=VALUE"):
        draw(result, tmp_path / "x.png")
    assert make_figure(result.at(Ix=4e-3)).axes[0].get_xlabel() == r"$\Omega_1$ ($\mathrm{rad}\,\mathrm{s}^{-1}$)"


@pytest.mark.parametrize("suffix", [".pdf", ".svg"])
def test_vector_figures_are_the_same_each_time(result: Result, tmp_path: Path, suffix: str) -> None:
    first, second = (draw(result, tmp_path / f"{name}{suffix}").read_bytes() for name in "ab")
    assert first == second


def test_units_and_edges() -> None:
    assert unit_text("kg m2") == r"\mathrm{kg}\,\mathrm{m}^{2}"
    assert unit_text("N s2/rad2") == r"\mathrm{N}\,\mathrm{s}^{2}\,\mathrm{rad}^{-2}"
    assert unit_text("1/s") == r"\mathrm{s}^{-1}"
    model = parse_sweep(LORENZ).model
    assert label(model, "rho") == r"$\rho$"
    assert label(parse_sweep(YAW).model, "Ix", -3) == r"$I_x$ ($10^{-3}\,\mathrm{kg}\,\mathrm{m}^{2}$)"
    np.testing.assert_allclose(edges(np.array([1.0, 2.0, 5.0])), [0.5, 1.5, 3.5, 6.5])
    assert axis_is_log(np.geomspace(1, 100, 5))
    np.testing.assert_allclose(edges(np.geomspace(1, 100, 3)), np.geomspace(10**-0.5, 10**2.5, 4))
    assert not axis_is_log(np.linspace(1, 100, 5))


def test_small_values_have_their_power_in_the_label(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("c: {start: 3, stop: 7, num: 5}", "Ix: {start: 3e-3, stop: 7e-3, num: 5}"))
    figure = make_figure(open_result(run_sweep(sweep, tmp_path)))
    figure.canvas.draw()
    axes = figure.axes[0]
    assert axes.get_ylabel() == r"$I_x$ ($10^{-3}\,\mathrm{kg}\,\mathrm{m}^{2}$)"
    assert "5" in [text.get_text() for text in axes.get_yticklabels()]
    assert axes.yaxis.get_offset_text().get_text() == ""


def test_cells_of_unsorted_axes_lie_at_their_values(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    result = open_result(run_sweep(make_sweep(YAW, ("{start: 3, stop: 7, num: 5}", "{values: [5, 3, 7]}")), tmp_path))
    mesh = _meshes(result)[0]
    shown = np.ma.getdata(mesh.get_array()).reshape(3, 9)
    np.testing.assert_array_equal(shown, result["region"].T[[1, 0, 2]])
    np.testing.assert_allclose(mesh.get_coordinates()[:, 0, 1], [2, 4, 6, 8])


def test_cells_without_an_exponent_are_not_neutral(result: Result) -> None:
    values = result["lyapunov"].copy()
    values[0, 0] = np.nan
    data = {**result.stored.data, "lyapunov": values}
    figure = make_figure(Result(result.sweep, Stored(data, *list(vars(result.stored).values())[1:])))
    void, largest = (c for c in figure.axes[1].collections if isinstance(c, QuadMesh))
    assert np.ma.getmaskarray(largest.get_array()).sum() == 1
    assert (~np.ma.getmaskarray(void.get_array())).sum() == 1


def test_a_line_is_hatched_where_nothing_is_computed(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    line = open_result(run_sweep(make_sweep(LORENZ), tmp_path))
    region = line["region"].copy()
    region[10:13] = Region.NONE
    unfinished = Result(
        line.sweep, Stored({**line.stored.data, "region": region}, *list(vars(line.stored).values())[1:])
    )
    axes = make_figure(unfinished).axes[0]
    assert sum(patch.get_hatch() is not None for patch in axes.patches) == 3
    assert axes.get_legend().get_texts()[-1].get_text() == "not computed"


def test_a_figure_says_at_which_values_it_is(result: Result) -> None:
    figure = make_figure(result.at(c=5))
    assert figure.get_suptitle() == r"$c = 5\,\mathrm{rad}\,\mathrm{s}^{-1}$"
    assert figure.axes[0].get_xlabel() == r"$\Omega_1$ ($\mathrm{rad}\,\mathrm{s}^{-1}$)"
    cell = make_figure(result.at(c=5).at(Omega1=50)).get_suptitle()
    assert r"\Omega_1 = 50" in cell
    assert "$c = 5" in cell
