"""Maps: any variable of two axes, its colours, its limits, its label."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from quavsweep.codes import Status
from quavsweep.errors import ConfigError
from quavsweep.plot import make_figure
from quavsweep.plot.code import VOID, WAS_CHAOTIC, codes_of
from tests.plot_runs import MAP, changed, legend_texts, meshes, run, unfinished


def _shown(mesh: object) -> np.ndarray:
    return np.ma.getdata(mesh.get_array()).reshape(5, 9)


@pytest.mark.parametrize(
    ("name", "variable", "index", "text"),
    [
        ("lyapunov", "lyapunov", 0, r"$\lambda_1$ ($\mathrm{s}^{-1}$)"),
        ("lyapunov.2", "lyapunov", 1, r"$\lambda_2$ ($\mathrm{s}^{-1}$)"),
        ("lyapunov_se.3", "lyapunov_se", 2, r"standard error of $\lambda_3$ ($\mathrm{s}^{-1}$)"),
        ("eigenvalue_re.1", "eigenvalue_re", 0, r"$\mathrm{Re}\,\mu_1$ ($\mathrm{s}^{-1}$)"),
        ("final_state.r", "final_state", 2, r"final $r$ ($\mathrm{rad}\,\mathrm{s}^{-1}$)"),
        ("peak.r", "peak", 1, r"peak $r$ ($\mathrm{rad}\,\mathrm{s}^{-1}$)"),
        ("sample_time.3", "sample_time", 2, r"time of sample 3 ($\mathrm{s}$)"),
        ("settle_time", "settle_time", None, r"settling time ($\mathrm{s}$)"),
        ("time_used", "time_used", None, r"time integrated ($\mathrm{s}$)"),
        ("sample_count", "sample_count", None, "number of samples"),
        ("first_time", "first_time", None, r"time until $p > 0.5$ ($\mathrm{s}$)"),
    ],
)
def test_any_variable_of_two_axes_is_a_map(name: str, variable: str, index: int | None, text: str) -> None:
    result = run(MAP)
    expected = result[variable] if index is None else result[variable][..., index]
    (mesh,) = meshes(result, name)
    known = np.isfinite(expected.T)
    np.testing.assert_array_equal(_shown(mesh)[known], expected.T[known])
    np.testing.assert_array_equal(np.ma.getmaskarray(mesh.get_array()).reshape(5, 9), ~known)
    assert make_figure(result, variables=[name]).axes[1].get_ylabel() == text


def test_panels_come_in_the_order_asked_for() -> None:
    result = run(MAP)
    first, second, third = meshes(result, "lyapunov.2", "region", "settle_time")
    np.testing.assert_array_equal(_shown(first), result["lyapunov"][..., 1].T)
    np.testing.assert_array_equal(_shown(second), result["region"].T)
    assert third.get_array().mask.any()


def test_codes_have_colours_and_a_legend() -> None:
    result = run(MAP)
    status, chaotic = meshes(result, "status", "was_chaotic")
    for code in codes_of(result, "status"):
        np.testing.assert_allclose(status.to_rgba(np.array([code.number]))[0, :3], to_rgb(code.colour), atol=1 / 255)
    np.testing.assert_allclose(chaotic.to_rgba(np.array([1]))[0, :3], to_rgb(WAS_CHAOTIC[1].colour), atol=1 / 255)
    figure = make_figure(result, variables=["status", "was_chaotic"])
    assert legend_texts(figure.axes[0]) == ["time over", "ended sink", "ended cycle"]
    assert legend_texts(figure.axes[1]) == ["not chaotic", "was chaotic"]
    assert len(figure.axes) == 2


def test_rates_are_white_at_zero_and_numbers_go_from_dark_to_light() -> None:
    rate, settle = meshes(run(MAP), "eigenvalue_re.1", "settle_time")
    assert min(rate.to_rgba(np.array([0.0]))[0, :3]) > 0.95
    dark, light = settle.to_rgba(np.array([settle.norm.vmin, settle.norm.vmax]))
    assert dark[:3].sum() < 1 < light[:3].sum()


def test_states_of_both_signs_are_white_at_zero() -> None:
    (mesh,) = meshes(run(MAP), "final_state.p")
    assert min(mesh.to_rgba(np.array([0.0]))[0, :3]) > 0.95
    assert mesh.norm.vmin == -mesh.norm.vmax


def test_an_error_does_not_look_like_a_value() -> None:
    result = run(MAP)
    values = np.where(result["lyapunov"] > 0, 1e-9, result["lyapunov"])
    (mesh,) = meshes(changed(result, lyapunov=values), "lyapunov")
    assert mesh.norm.vmax == pytest.approx(-mesh.norm.vmin / 10)


def test_a_few_values_far_out_do_not_set_the_scale() -> None:
    result = run(MAP)
    values = result["first_time"].copy()
    values[0, 0] = 1e9
    figure = make_figure(changed(result, first_time=values), variables=["first_time"])
    mesh = figure.axes[0].collections[-1]
    assert mesh.norm.vmax < 1e9
    assert mesh.colorbar.extend in ("max", "both")


@pytest.mark.parametrize("limits", [(-0.1, 0.05), (0.0, 0.05), (-0.05, -0.01)])
def test_limits_are_those_of_the_colours_and_white_is_still_zero(limits: tuple[float, float]) -> None:
    region, largest = meshes(run(MAP), "region", "lyapunov", limits=limits)
    assert (largest.norm.vmin, largest.norm.vmax) == limits
    if limits[0] <= 0 <= limits[1]:
        assert min(largest.to_rgba(np.array([0.0]))[0, :3]) > 0.95
    else:
        assert largest.to_rgba(np.array([limits[1]]))[0, 0] < 0.95
    assert region.norm.vmin == -0.5


@pytest.mark.parametrize("limits", [(1.0, 1.0), (2.0, 1.0), (float("nan"), 1.0), (0.0, float("inf"))])
def test_limits_that_do_not_ascend_are_refused(limits: tuple[float, float]) -> None:
    with pytest.raises(ConfigError, match="limits must ascend"):
        make_figure(run(MAP), limits=limits)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        (
            "lyapunow",
            r"no variable lyapunow to draw, did you mean lyapunov\?; possible are region, status, was_chaotic",
        ),
        ("lyapunov.4", r"no variable lyapunov.4 .* lyapunov \(.1, .2, .3\)"),
        ("final_state.x", r"no variable final_state.x .* final_state \(.p, .q, .r\)"),
        ("settle_time.p", r"no variable settle_time.p"),
        ("region.", r"no variable region. to draw"),
        ("samples.p", r"no variable samples.p"),
        ("Omega1", r"no variable Omega1"),
        ("state", r"no variable state"),
        ("", r"no variable  to draw"),
    ],
)
def test_an_unknown_variable_is_told_with_what_is_possible(name: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        make_figure(run(MAP), variables=[name])


def test_cells_without_a_number_are_grey_and_said_so() -> None:
    figure = make_figure(run(MAP), variables=["settle_time"])
    grey, _ = figure.axes[0].collections
    np.testing.assert_allclose(grey.to_rgba(np.array([1.0]))[0, :3], to_rgb(VOID), atol=1 / 255)
    assert legend_texts(figure.axes[0]) == ["no value"]


def test_a_variable_without_any_number_has_no_colour_bar() -> None:
    result = run(MAP)
    empty = changed(result, settle_time=np.full((9, 5), np.nan))
    figure = make_figure(empty, variables=["settle_time"])
    assert len(figure.axes) == 1
    assert figure.axes[0].get_legend().get_title().get_text() == r"settling time ($\mathrm{s}$)"


def test_unfinished_cells_are_hatched_in_every_panel() -> None:
    figure = make_figure(unfinished(run(MAP), np.s_[2:4]), variables=["status", "settle_time", "region"])
    for axes in figure.axes[:3]:
        assert axes.patch.get_hatch()
        assert legend_texts(axes)[-1] == "not computed"
        assert np.ma.getmaskarray(axes.collections[-1].get_array()).reshape(5, 9)[:, 2:4].all()


def test_a_status_is_shown_where_a_tile_failed() -> None:
    result = unfinished(run(MAP), np.s_[2:4])
    status = result["status"].copy()
    status[2:4] = Status.FAILED
    (mesh,) = meshes(changed(result, status=status), "status")
    assert not np.ma.getmaskarray(mesh.get_array()).any()
