"""Several results in one figure."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from quavsweep.codes import REGION, Region
from quavsweep.errors import ConfigError
from quavsweep.plot import make_figure
from tests.conftest import YAW
from tests.plot_runs import CELL, LINE, MAP, changed, legend_texts, run, unfinished

IX = YAW.replace("c: {start: 3, stop: 7, num: 5}", "Ix: {start: 3e-3, stop: 7e-3, num: 5}")


def test_each_result_has_a_panel_with_its_name() -> None:
    first, second = run(MAP, "one"), run(IX, "two$")
    figure = make_figure([first, second])
    assert [axes.get_title() for axes in figure.axes] == ["one", r"two\$"]
    for axes, result in zip(figure.axes, (first, second), strict=True):
        mesh = axes.collections[-1]
        np.testing.assert_array_equal(np.ma.getdata(mesh.get_array()).reshape(5, 9), result["region"].T)
    assert "I_x" in figure.axes[1].get_ylabel()


def test_the_legend_has_the_regions_of_all() -> None:
    result = run(MAP)
    alike = changed(result, region=np.full((9, 5), Region.SADDLE, dtype=np.int8))
    figure = make_figure([result, alike, unfinished(result, np.s_[:1])])
    present = {code.meaning for code in REGION if (result["region"] == code.number).any()}
    assert set(legend_texts(figure)) == present | {"saddle", "not computed"}
    assert not any(axes.get_legend() for axes in figure.axes)


def test_numbers_share_one_scale_and_one_bar() -> None:
    result = run(MAP)
    larger = changed(result, lyapunov=result["lyapunov"] * 3)
    figure = make_figure([result, larger], variables=["lyapunov"])
    meshes = [c for axes in figure.axes[:2] for c in axes.collections if isinstance(c, QuadMesh)]
    assert len({(mesh.norm.vmin, mesh.norm.vmax) for mesh in meshes}) == 1
    assert meshes[0].norm.vmin == pytest.approx(
        make_figure([larger], variables=["lyapunov"]).axes[0].collections[-1].norm.vmin
    )
    assert len(figure.axes) == 3
    assert figure.axes[2].get_ylabel() == r"$\lambda_1$ ($\mathrm{s}^{-1}$)"


@pytest.mark.parametrize(("count", "columns"), [(2, 2), (3, 3), (4, 2), (5, 3), (7, 3)])
def test_panels_stand_in_at_most_three_columns_and_share_labels(count: int, columns: int) -> None:
    figure = make_figure([run(MAP)] * count)
    assert len(figure.axes) == count
    grid = figure.axes[0].get_subplotspec().get_gridspec()
    assert (grid.ncols, grid.nrows) == (columns, -(-count // columns))
    assert figure.get_figwidth() == 7.0
    for i, axes in enumerate(figure.axes):
        assert bool(axes.get_ylabel()) == (i % columns == 0)
        assert bool(axes.get_xlabel()) == (i + columns >= count)


def test_results_of_one_axis_are_stacked() -> None:
    figure = make_figure([run(LINE, "one"), run(LINE, "two")], variables=["lyapunov"])
    assert [axes.get_title() for axes in figure.axes] == ["one", "two"]
    assert figure.axes[0].get_position().y0 > figure.axes[1].get_position().y1
    assert legend_texts(figure)[:3] == [rf"$\lambda_{k}$" for k in (1, 2, 3)]
    assert all(len(axes.child_axes) == 1 for axes in figure.axes)


def test_cells_are_compared_in_their_numbers() -> None:
    figure = make_figure([run(CELL, "one"), run(CELL, "two")], variables=["lyapunov"])
    assert [axes.get_title() for axes in figure.axes] == ["one: chaos", "two: chaos"]
    with pytest.raises(ConfigError, match="no variable orbit to compare; possible are samples, lyapunov, final_state"):
        make_figure([run(CELL)] * 2, variables=["orbit"])


def test_a_single_result_in_a_list_is_that_result() -> None:
    alone, listed = make_figure(run(MAP)), make_figure([run(MAP)])
    assert [axes.get_ylabel() for axes in alone.axes] == [axes.get_ylabel() for axes in listed.axes]


def test_a_curve_may_miss_some_of_the_maps() -> None:
    result, other = run(MAP), run(IX)
    figure = make_figure([result, other], overlays=["Omega1 = 200"])
    assert [len(axes.lines) for axes in figure.axes] == [2, 2]
    high = run(MAP.replace("start: 3, stop: 7", "start: 13, stop: 17"))
    figure = make_figure([result, high], overlays=["c = 5"])
    assert [len(axes.lines) for axes in figure.axes] == [2, 0]
    with pytest.raises(ConfigError, match="does not cross the map"):
        make_figure([result, high], overlays=["c = 10"])


def test_what_cannot_be_compared_is_named() -> None:
    with pytest.raises(ConfigError, match="results with 1 and 2 axes do not fit into one figure"):
        make_figure([run(MAP), run(LINE)])
    with pytest.raises(ConfigError, match="compared in one variable, not in region, lyapunov"):
        make_figure([run(MAP), run(MAP)], variables=["region", "lyapunov"])
    with pytest.raises(ConfigError, match="there is no result to draw"):
        make_figure([])
