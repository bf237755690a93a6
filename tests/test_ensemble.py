"""Ensembles: starts that depend on seed and index alone, the same in every cell; what a box may be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from quavsweep.codes import Region
from quavsweep.config import Sweep, dump_config, parse_sweep
from quavsweep.config.ensemble import make_ensemble
from quavsweep.errors import ConfigError
from quavsweep.export import write_csv
from quavsweep.grid import Tile
from quavsweep.integrate import cell_values
from quavsweep.point import compute_point
from quavsweep.result import open_result
from quavsweep.sweep import run_sweep

STATES = ("p", "q", "r")
ENSEMBLE = """
name: starts
model: quadrotor_yaw
initial: {r: 0.1}
axes:
  Omega1: {values: [100, 196.4]}
  ensemble: {num: 20, seed: 3, box: {p: [-2, 2], q: [-1, 3]}}
integrate: {method: rk4, dt: 0.02, duration: 800, segment: 50}
"""


def test_a_start_does_not_depend_on_their_number_nor_on_the_other_states() -> None:
    box = {"p": [-2.0, 2.0], "r": [-4.0, 6.0]}
    few, many = (make_ensemble(num, 7, box, STATES).quantities for num in (5, 1000))
    alone = make_ensemble(1000, 7, {"r": box["r"]}, STATES).quantities
    for name in ("p", "r"):
        assert few[name] == many[name][:5]
    assert alone["r"] == many["r"]
    assert make_ensemble(5, 8, box, STATES).quantities["p"] != few["p"]


def test_starts_are_even_in_the_box_and_independent() -> None:
    drawn = make_ensemble(20_000, 1, {"p": [-2.0, 2.0], "q": [0.0, 1.0]}, STATES).quantities
    p, q = np.array(drawn["p"]), np.array(drawn["q"])
    assert p.min() >= -2
    assert p.max() < 2
    for place in ((p + 2) / 4, q):
        counts = np.histogram(place, 20, (0, 1))[0]
        assert ((counts - 1000) ** 2 / 1000).sum() < 45  # chi-squared of 19 degrees of freedom: p < 0.001
    assert abs(np.corrcoef(p, q)[0, 1]) < 0.03
    assert abs(np.corrcoef(p[1:], p[:-1])[0, 1]) < 0.03


def test_known_draws_stay_what_they_are() -> None:
    drawn = make_ensemble(2, 1, {"p": [0.0, 1.0], "r": [0.0, 1.0]}, STATES).quantities
    words = np.random.Philox(key=1).random_raw(8)
    np.testing.assert_array_equal(drawn["p"], (words[[0, 4]] >> np.uint64(11)) * 2.0**-53)
    np.testing.assert_array_equal(drawn["r"], (words[[2, 6]] >> np.uint64(11)) * 2.0**-53)


def test_starts_are_the_same_in_every_cell() -> None:
    sweep = parse_sweep(ENSEMBLE)
    parameters, u = cell_values(sweep, Tile(0, 0, 40))
    np.testing.assert_array_equal(u[:20], u[20:])
    np.testing.assert_array_equal(u[:, 2], 0.1)
    np.testing.assert_array_equal(u[:20, 0], sweep.grid.axes[1].quantities["p"])
    omega = parameters[sweep.model.parameter_names.index("Omega1")]
    np.testing.assert_array_equal(omega, np.repeat([100, 196.4], 20))
    assert sweep.measures.verdict
    assert not sweep.measures.vectors


def test_every_sweep_over_starts_tells_chaos(tmp_path: Path) -> None:
    basin = """
name: basin
model: lorenz
initial: {z: 20}
axes: {x: {start: -9, stop: 10, num: 6}, y: {start: -8, stop: 8, num: 5}}
integrate: {method: rk4, dt: 0.01, duration: 100}
"""
    sweep = parse_sweep(basin)
    assert sweep.measures.verdict
    assert parse_sweep(dump_config(sweep.canonical())).canonical() == sweep.canonical()
    assert (open_result(run_sweep(sweep, tmp_path))["region"] == Region.CHAOS).all()
    assert not parse_sweep(basin + "measures: {lyapunov: {}}").measures.verdict
    assert not parse_sweep(ENSEMBLE, changes=["axes.ensemble=", "initial={p: 0, q: 1, r: 1}"]).measures.verdict


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("axes.ensemble.num=0", r"axes.ensemble.num: 0 is not accepted; it should be a whole number from 1 to 1000000"),
        ("axes.ensemble.box={}", r"axes.ensemble.box: is empty; give an interval .* of one or more of p, q, r"),
        ("axes.ensemble.box=", r"axes.ensemble.box: is missing"),
        ("axes.ensemble.box.P=[1, 2]", r"axes.ensemble.box.P: .* has no such state; it has p, q, r"),
        ("axes.ensemble.box.Omega1=[1, 2]", r"axes.ensemble.box.Omega1: .* has no such state; it has p, q, r"),
        ("axes.ensemble.box.r=[1, 2]", r"initial.r: is fixed here and varied in axes.ensemble.box.r .*keep one"),
        ("axes.ensemble.box.p=[2, 2]", r"axes.ensemble.box.p: \[2, 2\] is no interval; \[low, high\] with low < high"),
        ("axes.ensemble.box.p=[1]", r"axes.ensemble.box.p: a list is not accepted; it should be a list of numbers"),
        ("axes.ensemble.start=1", r"axes.ensemble.start: unknown key; possible keys are num, seed, box"),
        ("axes.ensemble.seed=-1", r"axes.ensemble.seed: -1 is not accepted"),
        ("axes.ensemble=7", r"axes.ensemble: is not a mapping of keys; possible keys are num, seed, box"),
        ("axes.c={values: [1]}", r"test.yaml:7: axes.ensemble: comes before axes.c .*; it must be the last axis"),
        ("effort={max_duration: 1600}", r"effort: is not for axes.ensemble .*all followed equally long; a longer"),
        ("axes.ensemble.num=1000001", r"axes.ensemble.num: 1000001 is not accepted"),
        ("initial=", r"initial.r: is missing"),
    ],
)
def test_what_is_no_ensemble_is_told_with_what_is_possible(change: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        parse_sweep(ENSEMBLE, "test.yaml", [change])


def test_a_state_is_not_drawn_and_varied() -> None:
    text = ENSEMBLE.replace("Omega1: {values", "p: {values")
    with pytest.raises(ConfigError, match=r"axes.ensemble.box.p: is drawn here and varied in axes.p \(line 6\)"):
        parse_sweep(text, "test.yaml")


def test_a_canonical_config_gives_the_same_ensemble() -> None:
    sweep = parse_sweep(ENSEMBLE)
    again = parse_sweep(dump_config(sweep.canonical()))
    assert again.grid == sweep.grid
    assert again.canonical() == sweep.canonical()


def test_a_start_is_found_again_by_its_number(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(ENSEMBLE)
    result = open_result(run_sweep(sweep, tmp_path))
    start = result.at(ensemble=17)
    assert start.sweep.config.initial["p"] == result["p"][17]
    assert start.fixed == ("p", "q")
    np.testing.assert_array_equal(start["region"], result["region"][:, 17])
    point = compute_point(sweep, {"Omega1": 196.4, "ensemble": 17})
    assert point.indices == (1, 17)
    for name, value in point.values.items():
        assert np.asarray(value).tobytes() == result[name][1, 17].tobytes()
    other = compute_point(sweep, {"Omega1": 196.4, "p": 1.0, "q": 1.0})
    assert other.indices is None
    with pytest.raises(ConfigError, match="ensemble has no number 20; a whole number from 0 to 19"):
        compute_point(sweep, {"Omega1": 196.4, "ensemble": 20})
    table = (tmp_path / "region.csv").open("w+")
    write_csv(result, ["region"], table)
    table.seek(0)
    assert table.readline() == "Omega1,ensemble,p,q,region\n"
    assert table.readline().startswith(f"100.0,0,{float(result['p'][0])!r},{float(result['q'][0])!r},")


def test_xarray_finds_the_starts_as_coordinates(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    xarray = pytest.importorskip("xarray")
    path = run_sweep(make_sweep(ENSEMBLE), tmp_path)
    own, file = open_result(path).to_xarray(), xarray.open_dataset(path, engine="h5netcdf")
    for data in (own, file):
        assert {"ensemble", "p", "q"} <= set(data.coords)
        assert data["p"].dims == ("ensemble",)
