"""One cell on its own: to the bit the map's, and what else is known of it."""

from __future__ import annotations

import numpy as np
import pytest

from quavsweep.codes import Region, Status
from quavsweep.config import parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.point import compute_point
from quavsweep.result import Result, open_result
from quavsweep.sweep import run_sweep
from tests.conftest import LORENZ, YAW

LONG = YAW.replace(": 200,", ": 1000,").replace("600", "3000").replace("num: 9", "num: 31").replace("num: 5", "num: 13")


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return open_result(run_sweep(parse_sweep(LONG), tmp_path_factory.mktemp("run")))


def test_twenty_random_cells_equal_the_map_to_the_bit(result: Result) -> None:
    random = np.random.default_rng(3)
    regions = set()
    for cell in random.choice(result.sweep.grid.size, 20, replace=False):
        indices = tuple(int(i) for i in np.unravel_index(cell, result.sweep.grid.shape))
        values = {axis.name: axis.values[i] for axis, i in zip(result.sweep.grid.axes, indices, strict=True)}
        point = compute_point(parse_sweep(LONG), values)
        assert point.indices == indices
        for name in result.variables:
            assert np.asarray(point.values[name]).tobytes() == result[name][indices].tobytes(), name
        regions.add(int(point.values["region"]))
    assert {Region.SINK, Region.PERIODIC} <= regions


def test_a_value_that_was_typed_means_that_of_the_grid() -> None:
    sweep = parse_sweep(YAW.replace("num: 9", "num: 70"))
    typed = round(sweep.grid.axes[0].values[24], 9)
    assert typed != sweep.grid.axes[0].values[24]
    point = compute_point(sweep, {"Omega1": typed, "c": 5})
    assert point.indices == (24, 2)
    assert point.sweep.parameters["Omega1"] == sweep.grid.axes[0].values[24]


def test_values_beside_the_grid_are_used_as_they_are() -> None:
    sweep = parse_sweep(YAW)
    between = compute_point(sweep, {"Omega1": 51, "c": 5})
    assert between.indices is None
    assert between.sweep.parameters["Omega1"] == 51
    other = compute_point(sweep, {"Omega1": 50, "c": 5, "Ix": 5e-3, "r": 0.5})
    assert other.indices is None
    assert other.sweep.parameters["Ix"] == 5e-3
    assert other.orbit[0].tolist() == [1e-3, 1e-3, 0.5]
    same = compute_point(sweep, {"Omega1": 50, "c": 5, "Ix": 4.9e-3, "r": 1e-3})
    assert same.indices == (0, 2)


def test_the_orbit_ends_where_the_cell_ends(result: Result) -> None:
    for omega in (100.0, 260.0):
        point = compute_point(result.sweep, {"Omega1": omega, "c": 5})
        assert point.time[0] == 0
        assert point.time[-1] == pytest.approx(float(point.values["time_used"]))
        assert point.orbit[0].tolist() == [1e-3] * 3
        np.testing.assert_array_equal(point.orbit[-1], point.values["final_state"])


def test_exponents_converge_to_those_of_the_map(result: Result) -> None:
    i, j = np.argwhere(result["region"] == Region.CHAOS)[0]
    point = compute_point(result.sweep, {"Omega1": result["Omega1"][i], "c": result["c"][j]})
    assert point.values["status"] == Status.TIME_OVER
    np.testing.assert_array_equal(point.exponents[-1], point.values["lyapunov_raw"])
    np.testing.assert_array_equal(point.errors[-1], point.values["lyapunov_se"])
    assert point.averaged_until[0] == pytest.approx(1000 + 250)
    assert point.averaged_until[-1] == pytest.approx(4000)
    sink = compute_point(result.sweep, {"Omega1": 100 - 5, "c": 5})
    assert sink.values["status"] == Status.ENDED_SINK
    assert sink.averaged_until[0] == pytest.approx(250)


def test_a_cell_that_diverges() -> None:
    point = compute_point(parse_sweep(LORENZ.replace("start: 0.5", "start: 1")), {"rho": 600})
    assert point.values["region"] == Region.UNBOUNDED
    assert point.exponents.shape == (0, 3)
    assert len(point.time) == len(point.orbit)


def test_a_sweep_without_exponents() -> None:
    point = compute_point(parse_sweep(YAW.replace("lyapunov: {exponents: 3, block: 25}", "")), {"Omega1": 100, "c": 4})
    assert point.exponents.shape == (0, 0)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"Omega1": 100}, "c has no value; give Omega1=..., c=..."),
        ({"Omega1": 100, "c": 5, "x": 1}, "quadrotor_yaw has no x; it has Omega1, c, Ix"),
        ({"Omega1": -1, "c": 5}, "Omega1 cannot be -1; it must be >= 0"),
        ({"Omega1": float("nan"), "c": 5}, "Omega1 cannot be nan"),
    ],
)
def test_what_is_wrong_is_named(values: dict[str, float], says: str) -> None:
    with pytest.raises(ConfigError, match=says.replace("...", r"\.\.\.")):
        compute_point(parse_sweep(YAW), values)


def test_a_result_at_a_value_has_one_axis_less(result: Result) -> None:
    line = result.at(c=5.01)
    assert [axis.name for axis in line.sweep.grid.axes] == ["Omega1"]
    assert line.sweep.parameters["c"] == 5.0
    np.testing.assert_array_equal(line["lyapunov"], result["lyapunov"][:, 6])
    assert line.stored.dims["lyapunov"] == ("Omega1", "exponent")
    cell = line.at(Omega1=50)
    assert cell["region"].shape == ()
    with pytest.raises(ConfigError, match="c has no value 9; 3 to 7"):
        result.at(c=9)
    with pytest.raises(ConfigError, match="there is no axis q; the axes are Omega1, c"):
        result.at(q=9)


def test_a_notebook_shows_the_figure(result: Result) -> None:
    shown = result._repr_png_()
    assert shown is not None
    assert shown.startswith(b"\x89PNG")
    assert "Omega1: 31 x c: 13" in repr(result)
