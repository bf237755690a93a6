"""Figures of no axes: orbit, return plot, exponents, final state; never an error."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep.codes import Region
from quavsweep.errors import ConfigError
from quavsweep.plot import make_figure
from tests.plot_runs import CELL, legend_texts, run, unfinished, without

ORBIT = CELL.replace("max: 20}", "max: 20}, orbit: {every: 0.1, until: 60}")
SINK = ORBIT.replace("rho: 28", "rho: 14")


def test_samples_are_drawn_against_the_one_before() -> None:
    result = run(CELL)
    (axes,) = make_figure(result).axes
    x = result["samples"][:, 0]
    np.testing.assert_array_equal(axes.lines[0].get_xydata(), np.column_stack([x[:-1], x[1:]]))
    assert axes.get_xlabel() == "$x$ where $z = 27$, $n$th"
    assert axes.get_aspect() == 1.0


def test_an_orbit_is_drawn_in_space_and_against_time() -> None:
    result = run(ORBIT)
    space, *series = make_figure(result, variables=["orbit"]).axes
    early, late, start = (np.array(line.get_data_3d()).T for line in space.lines)
    np.testing.assert_array_equal(np.concatenate([early[:-1], late]), result["orbit"])
    np.testing.assert_array_equal(start, [[1, 1, 20]])
    assert [axes.get_ylabel() for axes in series] == ["$x$", "$y$", "$z$"]
    assert series[-1].get_xlabel() == "$t$"
    np.testing.assert_array_equal(series[1].lines[1].get_ydata(), result["orbit"][200:, 1])
    assert series[0].lines[2].get_xdata() == [20.0, 20.0]


def test_an_orbit_ends_in_its_equilibrium() -> None:
    result = run(SINK)
    assert result["region"] == Region.SINK
    space = make_figure(result, variables=["orbit"]).axes[0]
    np.testing.assert_array_equal(np.ravel(space.lines[3].get_data_3d()), result["equilibrium"])
    assert legend_texts(space)[-1] == "equilibrium"


def test_exponents_have_error_bars_and_their_numbers() -> None:
    result = without(run(CELL), "samples")
    (axes,) = make_figure(result).axes
    np.testing.assert_array_equal(axes.containers[0].lines[0].get_ydata(), result["lyapunov"])
    (bars,) = axes.containers[0].lines[2]
    ends = np.array([segment[:, 1] for segment in bars.get_segments()])
    np.testing.assert_allclose(np.ptp(ends, axis=1), 2 * result["lyapunov_se"])
    assert [text.get_text().split("\n")[0] for text in axes.get_xticklabels()] == [
        rf"$\lambda_{{{k}}}$" for k in (1, 2, 3)
    ]


@pytest.mark.parametrize("text", [CELL, ORBIT, SINK])
def test_the_region_is_in_the_title(text: str) -> None:
    figure = make_figure(run(text))
    region = "sink" if text is SINK else "chaos"
    assert figure.get_suptitle().replace("\n", " ").startswith("lorenz, ")
    assert figure.get_suptitle().endswith(region)


def test_a_cell_without_measures_has_its_final_state() -> None:
    result = without(run(CELL), "samples", "lyapunov", "lyapunov_se")
    (axes,) = make_figure(result).axes
    names, values = (text.get_text().split("\n") for text in axes.texts)
    assert names == ["final $x$", "final $y$", "final $z$"]
    assert values[0].startswith(f"$= {result['final_state'][0]:.4g}")


def test_a_cell_that_is_not_computed_says_so() -> None:
    (text,) = make_figure(unfinished(run(ORBIT), ())).texts
    assert text.get_text().endswith("not computed")


def test_variables_choose_the_parts() -> None:
    figure = make_figure(run(ORBIT), variables=["lyapunov", "final_state"])
    assert len(figure.axes) == 2
    with pytest.raises(
        ConfigError, match=r"no variable sample to draw, did you mean samples\?; possible are orbit, samples"
    ):
        make_figure(run(ORBIT), variables=["sample"])


def test_limits_are_those_of_the_exponents() -> None:
    figure = make_figure(run(ORBIT), variables=["lyapunov"], limits=(-1.0, 1.0))
    assert figure.axes[0].get_ylim() == (-1.0, 1.0)
