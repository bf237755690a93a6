"""Zipped axes: a curve's points are the cells that a plain sweep has there, and every reader copes with them."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from quavsweep.config import Sweep, dump_config, parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.export import write_csv, write_netcdf
from quavsweep.grid import Axis
from quavsweep.overview import Lookout
from quavsweep.plot.along import axis_text, drawn_axes
from quavsweep.plot.figure import make_figure
from quavsweep.plot.overlay import make_curves
from quavsweep.point import compute_point
from quavsweep.preview import preview_run
from quavsweep.result import open_result
from quavsweep.sweep import run_sweep

OMEGA = "[197.4, 196.9, 196.4, 195.9, 195.4]"
CURVE = f"""
name: hover
model: quadrotor_yaw
initial: {{p: 0.001, q: 0.001, r: 0.001}}
axes:
  hover:
    zip: {{Omega1: {OMEGA}, c: {{start: 3, stop: 7, num: 5}}}}
integrate: {{method: rk4, dt: 0.02, transient: 200, duration: 600}}
measures: {{lyapunov: {{exponents: 3, block: 25}}}}
"""
PLANE = CURVE.replace("  hover:\n    zip: {", "  ").replace("]", "]}").replace("Omega1: [", "Omega1: {values: [")
PLANE = PLANE.replace("num: 5}}", "num: 5}").replace("}, c: {", "}\n  c: {")


def test_a_curve_has_the_cells_of_the_plane_to_the_bit(tmp_path: Path) -> None:
    curve = open_result(run_sweep(parse_sweep(CURVE), tmp_path / "curve"))
    plane = open_result(run_sweep(parse_sweep(PLANE), tmp_path / "plane"))
    assert plane["region"].shape == (5, 5)
    assert curve["region"].shape == (5,)
    for name in curve.variables:
        for i in range(5):
            assert curve[name][i].tobytes() == plane[name][i, i].tobytes(), name
    np.testing.assert_array_equal(curve["hover"], range(5))
    np.testing.assert_array_equal(curve["c"], [3, 4, 5, 6, 7])
    assert curve.stored.dims["c"] == ("hover",)


def test_a_canonical_config_gives_the_same_curve() -> None:
    sweep = parse_sweep(CURVE)
    again = parse_sweep(dump_config(sweep.canonical()))
    assert again.grid == sweep.grid
    assert again.canonical() == sweep.canonical()
    assert sweep.grid.axes[0].values == (0, 1, 2, 3, 4)


def test_a_cell_is_found_by_number_and_by_quantity(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(CURVE)
    result = open_result(run_sweep(sweep, tmp_path))
    for at in ({"hover": 3}, {"c": 6.1}, {"Omega1": 195.9}, {"Omega1": 195.9, "c": 6.0}):
        assert result.at(**at).sweep.parameters["Omega1"] == 195.9
        assert result.at(**at)["lyapunov"].tobytes() == result["lyapunov"][3].tobytes()
    with pytest.raises(ConfigError, match="c = 3 is at hover = 0, not at 3"):
        result.at(Omega1=195.9, c=3)
    with pytest.raises(ConfigError, match="the axes are hover, Omega1, c"):
        result.at(Ix=4)
    for given in ({"hover": 3}, {"Omega1": 195.9, "c": 6.0}):
        point = compute_point(sweep, given)
        assert point.indices == (3,)
        assert point.chosen == ("Omega1", "c")
        for name, value in point.values.items():
            assert np.asarray(value).tobytes() == result[name][3].tobytes()
    assert compute_point(sweep, {"Omega1": 195.9, "c": 5.0}).indices is None
    with pytest.raises(ConfigError, match=r"hover has no value; give hover=..., or Omega1=... c=..."):
        compute_point(sweep, {"Omega1": 195.9})


def test_tables_and_files_hold_every_quantity(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    sweep = parse_sweep(CURVE)
    assert preview_run(sweep, tmp_path).cells == 5
    path = run_sweep(sweep, tmp_path)
    result, table = open_result(path), io.StringIO()
    write_csv(result, ["region"], table)
    assert table.getvalue().splitlines()[:2] == ["hover,Omega1,c,region", "0,197.4,3.0,sink"]
    write_netcdf(result, ["region"], tmp_path / "region.nc")
    for file in (path, tmp_path / "region.nc"):
        data = xarray.open_dataset(file, engine="h5netcdf")
        assert {"hover", "Omega1", "c"} <= set(data.coords)
        assert data["c"].dims == ("hover",)
    assert Lookout.of(tmp_path).look().to_json()["axes"] == {"hover": 5}


def test_figures_are_drawn_over_the_first_quantity(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    line = open_result(run_sweep(make_sweep(CURVE), tmp_path / "line"))
    axes = make_figure(line, overlays=["middle: c = 5"]).axes[0]
    assert axes.get_xlabel().startswith(r"$\Omega_1$")
    assert r"c = 7 \ldots 3" in axes.get_xlabel()
    (curve,) = make_curves(["c = 5.5"], [line.sweep])[0]
    np.testing.assert_allclose(np.concatenate(curve.pieces), 196.15, atol=1e-6)
    plane = make_sweep(CURVE, ("integrate:", "  Ix: {values: [4e-3, 5e-3]}\nintegrate:"))
    axes = make_figure(open_result(run_sweep(plane, tmp_path / "map"))).axes[0]
    assert r"c = 7 \ldots 3" in axes.get_xlabel()


def test_a_curve_that_comes_back_is_drawn_over_its_points(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(CURVE, (OMEGA, "[196, 197, 196, 195, 196]"))
    (axis,) = drawn_axes(sweep)
    assert axis == sweep.grid.axes[0]
    text = axis_text(sweep.model, axis)
    assert text.startswith("point of hover\n")
    assert r"= 195 \ldots 197" in text
    assert r"c = 3 \ldots 7" in text
    make_figure(open_result(run_sweep(sweep, tmp_path)))


def test_starts_may_lie_along_a_curve(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    text = CURVE.replace("{p: 0.001, q: 0.001, r: 0.001}", "{r: 0.1}").replace(
        "integrate:", "  ring: {zip: {p: [1, 0.1, -1], q: [0, 1, 0]}}\nintegrate:"
    )
    sweep = make_sweep(text, ("measures: {lyapunov: {exponents: 3, block: 25}}", ""))
    assert sweep.start_axes == ("ring",)
    assert sweep.measures.verdict
    result = open_result(run_sweep(sweep, tmp_path))
    assert result["basin_share"].shape[0] == 5
    points = result.points
    assert points["basin_share"].shape[0] == 5
    assert points.stored.attributes["basin_share"]["coordinates"] == "Omega1 c"
    np.testing.assert_array_equal(sweep.starts, [[1, 0, 0.1], [0.1, 1, 0.1], [-1, 0, 0.1]])
    make_figure(result)


def test_an_ensemble_may_stand_behind_a_curve(make_sweep: Callable[..., Sweep]) -> None:
    behind = ("integrate:", "  ensemble: {num: 3, box: {p: [-1, 1]}}\nintegrate:")
    sweep = make_sweep(CURVE, ("p: 0.001, ", ""), behind)
    assert [axis.name for axis in sweep.grid.axes] == ["hover", "ensemble"]
    assert sweep.points.axes[0].quantities["c"] == (3, 4, 5, 6, 7)


def test_relations_are_checked_along_a_curve() -> None:
    inertia = "zip: {Ix: [4e-3, 5e-3], Iy: [9.8e-3, 20e-3]}"
    text = CURVE.replace(f"zip: {{Omega1: {OMEGA}, c: {{start: 3, stop: 7, num: 5}}}}", inertia)
    assert any("50 % of the cells" in warning for warning in parse_sweep(text).warnings)


def test_picking_points_keeps_them_together() -> None:
    axis = Axis("hover", (0, 1, 2), (("Omega1", (5.0, 6.0, 7.0)), ("c", (1.0, 2.0, 3.0))))
    assert axis.picked([2, 0]).quantities == {"Omega1": (7.0, 5.0), "c": (3.0, 1.0)}


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("num: 5", "num: 4", r"x.yaml:7: axes.hover.zip.c: has 4 values, axes.hover.zip.Omega1 has 5; equally many"),
        (", c: {", ", d2: {", "axes.hover.zip.d2: quadrotor_yaw has no such parameter or state, did you mean d"),
        ("  hover:", "  c:", "x.yaml:6: axes.c: is a quantity of quadrotor_yaw, and so no name"),
        ("  hover:", "  region:", "x.yaml:6: axes.region: cannot be the name of an axis"),
        ("  hover:", "  exponent:", "x.yaml:6: axes.exponent: cannot be the name of an axis"),
        ("{start: 3, stop: 7, num: 5}", "5", "axes.hover.zip.c: 5 is not accepted; it should be a list of numbers, or"),
        ("{start: 3, stop: 7, num: 5}", "[1, a]", r"axes.hover.zip.c \(item 2\): 'a' is not accepted; .* a number"),
        ("{start: 3, stop: 7, num: 5}", "{strt: 3}", "axes.hover.zip.c.strt: unknown key, did you mean start"),
        ("{start: 3, stop: 7, num: 5}", "{start: 3}", "axes.hover.zip.c.stop: is missing, and so is num"),
        ("{start: 3, stop: 7, num: 5}", "[]", "axes.hover.zip.c: an empty list is not accepted"),
        ("integrate:", "  c: {values: [3]}\nintegrate:", r"zip.c: is varied in axes.c \(line 8\) already; keep one"),
        ("integrate:", "  k: {zip: {c: [3]}}\nintegrate:", r"axes.k.zip.c: is varied in axes.hover.zip.c \(line 7\)"),
        ("initial:", "parameters: {c: 3}\ninitial:", r"parameters.c: is fixed here and varied in axes.hover.zip.c"),
        ("    zip:", "    num: 4\n    zip:", r"x.yaml:7: axes.hover.num: cannot stand beside axes.hover.zip"),
        ("    zip:", "    spacing: log\n    zip:", r"x.yaml:7: axes.hover.spacing: cannot stand beside"),
        ("zip:", "zpi:", "axes.hover.zpi: unknown key, did you mean zip"),
        ("[197.4,", "[-1,", r"axes.hover.zip.Omega1 \(item 1\): -1 rad/s is outside the domain"),
        ("integrate:", "  Iz: {num: 3}\nintegrate:", r"axes.Iz.start: is missing, .* or \{zip\} of several quantities"),
    ],
)
def test_what_is_no_curve_is_told_with_its_keys(old: str, new: str, says: str) -> None:
    assert old in CURVE
    with pytest.raises(ConfigError, match=says):
        parse_sweep(CURVE.replace(old, new, 1), "x.yaml")


def test_an_empty_zip_says_what_it_may_hold() -> None:
    text = CURVE.replace(f"zip: {{Omega1: {OMEGA}, c: {{start: 3, stop: 7, num: 5}}}}", "zip: {}")
    with pytest.raises(ConfigError, match=r"axes.hover.zip: is empty; give \[a list\] or \{start, stop, num\}"):
        parse_sweep(text)
