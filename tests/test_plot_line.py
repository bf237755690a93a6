"""Figures of one axis: orbit diagrams, exponents, other numbers, and the band of regions."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import FillBetweenPolyCollection

from quavsweep.codes import Region
from quavsweep.errors import ConfigError
from quavsweep.plot import make_figure
from quavsweep.plot.orbit_diagram import sampled_state
from quavsweep.plot.scale import edges
from quavsweep.result import Result
from tests.conftest import LORENZ, YAW
from tests.plot_runs import LINE, MAP, changed, legend_texts, run, unfinished, without

SECTION = "samples: {section: {of: z, at: 27}, max: 20}"


def _panels(result: Result, *variables: str, **options: object) -> list[Axes]:
    """Return the panels of a figure, from the top."""
    return make_figure(result, variables=variables, **options).axes


def _dots(axes: Axes) -> np.ndarray:
    (line,) = (line for line in axes.lines if line.get_rasterized())
    return line.get_xydata()[np.isfinite(line.get_ydata())]


def test_samples_are_an_orbit_diagram_above_the_exponents() -> None:
    result = run(LINE)
    diagram, exponents = _panels(result)
    assert diagram.get_ylabel() == "$x$ where $z = 27$"
    assert exponents.get_ylabel() == r"$\lambda_k$"
    assert diagram.get_shared_x_axes().joined(diagram, exponents)
    assert exponents.get_xlabel() == r"$\rho$"
    dots = _dots(diagram)
    rho = result["rho"]
    for i in np.flatnonzero(result["region"] == Region.CHAOS):
        expected = result["samples"][i, :, 0]
        np.testing.assert_array_equal(np.sort(dots[dots[:, 0] == rho[i], 1]), np.sort(expected[np.isfinite(expected)]))


def test_a_sink_is_shown_where_its_orbit_ends() -> None:
    result = run(LINE)
    dots = _dots(_panels(result)[0])
    sinks = np.flatnonzero(result["region"] == Region.SINK)
    assert len(sinks) > 1
    for i in sinks:
        np.testing.assert_array_equal(dots[dots[:, 0] == result["rho"][i], 1], result["equilibrium"][i, :1])


@pytest.mark.parametrize(
    ("samples", "state"), [("maxima: y", "y"), ("section: {of: x}", "y"), ("section: {of: y}", "x"), ("every: 1", "x")]
)
def test_the_state_of_an_orbit_diagram_is_one_that_varies(samples: str, state: str) -> None:
    sweep = run(
        LORENZ.replace("block: 5}", f"block: 5}}, samples: {{{samples}, max: 3}}").replace("num: 60", "num: 2")
    ).sweep
    assert sampled_state(sweep) == state


def test_each_exponent_has_its_band_of_errors() -> None:
    result = run(LINE)
    (axes,) = _panels(result, "lyapunov")
    for k in range(3):
        np.testing.assert_array_equal(axes.lines[k].get_ydata(), result["lyapunov"][:, k])
    bands = [c for c in axes.collections if isinstance(c, FillBetweenPolyCollection)]
    assert len(bands) == 3
    value, error = result["lyapunov"][20, 0], result["lyapunov_se"][20, 0]
    (path,) = bands[0].get_paths()[:1]
    heights = path.vertices[path.vertices[:, 0] == result["rho"][20], 1]
    np.testing.assert_allclose([heights.min(), heights.max()], [value - error, value + error])
    assert legend_texts(axes)[:3] == [rf"$\lambda_{k}$" for k in (1, 2, 3)]
    looks = {(line.get_color(), line.get_linestyle()) for line in axes.lines[:3]}
    assert len(looks) == 3


def test_variables_choose_the_panels() -> None:
    result = run(LINE)
    panels = _panels(result, "samples.y", "lyapunov.2", "settle_time", "region", "sample_time")
    texts = [axes.get_ylabel() for axes in panels]
    assert texts == ["$y$ where $z = 27$", r"$\lambda_2$", "settling time", "", "time of the samples"]
    np.testing.assert_array_equal(panels[1].lines[0].get_ydata(), result["lyapunov"][:, 1])
    assert len(_dots(panels[4])) > 50
    assert [axes.get_xlabel() for axes in panels] == ["", "", "", "", r"$\rho$"]


def test_codes_are_named_beside_their_panel() -> None:
    result = run(LINE)
    (axes,) = _panels(result, "status")
    assert [text.get_text() for text in axes.get_yticklabels()] == ["time over", "ended sink", "diverged"]
    np.testing.assert_array_equal(axes.lines[1].get_xdata(), result["rho"][result["status"] == 2])


def test_without_exponents_there_is_something_to_see() -> None:
    result = without(run(LINE), "lyapunov", "lyapunov_se", "samples")
    (axes,) = _panels(result)
    assert axes.get_ylabel() == "final state"
    assert [line.get_linestyle() for line in axes.lines[:3]] == ["None"] * 3
    np.testing.assert_array_equal(axes.lines[2].get_ydata(), result["final_state"][:, 2])
    assert legend_texts(axes)[:3] == ["$x$", "$y$", "$z$"]


def test_peaks_and_first_times_come_before_final_states() -> None:
    result = without(run(MAP).at(c=5), "lyapunov", "lyapunov_se", "samples")
    peak, first = _panels(result)
    assert peak.get_ylabel() == r"peak state ($\mathrm{rad}\,\mathrm{s}^{-1}$)"
    np.testing.assert_array_equal(peak.lines[1].get_ydata(), result["peak"][:, 1])
    np.testing.assert_array_equal(first.lines[0].get_ydata(), result["first_time"])


def test_a_panel_without_numbers_says_so() -> None:
    result = run(LINE)
    (axes,) = _panels(changed(result, settle_time=np.full(60, np.nan)), "settle_time")
    assert [text.get_text() for text in axes.texts] == ["no value"]
    assert not len(axes.get_yticks())


def test_a_cell_without_neighbours_is_seen() -> None:
    result = run(LORENZ.replace("num: 60", "num: 100"))
    (axes,) = _panels(unfinished(result, np.r_[0:50, 51:100]))
    marked = axes.lines[0].get_markevery()
    assert np.flatnonzero(marked).tolist() == [50]
    assert sum(patch.get_hatch() is not None for patch in axes.patches) == 99


def test_many_unfinished_neighbours_are_hatched_together() -> None:
    result = run(LORENZ.replace("num: 60", "num: 200"))
    (axes,) = _panels(unfinished(result, np.r_[0:50, 51:120]))
    hatched = [patch for patch in axes.patches if patch.get_hatch()]
    ends = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in hatched]
    borders = edges(result["rho"])
    np.testing.assert_allclose(ends, [(borders[0], borders[50]), (borders[51], borders[120])])


def test_limits_are_those_of_the_vertical_axis() -> None:
    for axes in _panels(run(LINE), limits=(-20.0, 5.0)):
        assert axes.get_ylim() == (-20.0, 5.0)


def test_an_unknown_variable_of_a_line_is_named() -> None:
    with pytest.raises(
        ConfigError, match=r"no variable sample to draw, did you mean samples\?; .* samples \(.x, .y, .z\)"
    ):
        make_figure(run(LINE), variables=["sample"])


def test_values_in_any_order_are_drawn_along_the_axis() -> None:
    result = run(
        YAW.replace("Omega1: {start: 50, stop: 500, num: 9}\n", "").replace(
            "{start: 3, stop: 7, num: 5}", "{values: [5, 3, 7]}"
        )
    )
    (axes,) = _panels(result)
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), [3, 5, 7])
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), result["lyapunov"][[1, 0, 2], 0])
