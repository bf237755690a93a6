"""Reductions: what all starts of a parameter point say together, whatever the order of the axes and the layout."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from quavsweep.codes import Certificate, Region
from quavsweep.config import Sweep
from quavsweep.measures.variable import REGION_VARIABLE
from quavsweep.reduction import KINDS, lifetimes, survival_of
from quavsweep.result import open_result
from quavsweep.store import check_result
from quavsweep.sweep import run_sweep
from tests.test_ensemble import ENSEMBLE

LORENZ = """
name: lorenz
model: lorenz
initial: {z: 20}
axes:
  x: {start: -5, stop: 5, num: 6}
  rho: {values: [0.5, 10, 28]}
  y: {start: -5, stop: 6, num: 5}
integrate: {method: rk4, dt: 0.01, duration: 160}
"""


def test_shares_are_counts(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    result = open_result(run_sweep(make_sweep(ENSEMBLE), tmp_path))
    check_result(tmp_path / "result.h5")
    assert result.stored.dims["basin_share"] == ("Omega1", "kind")
    np.testing.assert_array_equal(result["starts"], [20, 20])
    for code in KINDS:
        share = result["basin_share"][:, list(result["kind"]).index(code.name)]
        np.testing.assert_allclose(share, (result["region"] == code.number).mean(axis=1))
    for i in range(2):
        for row in range(2):
            ends = result["attractor"][i] == row + 1
            assert result["attractor_share"][i, row] == ends.mean()
            assert (result["attractor_kind"][i, row] == Certificate.SINK) == ends.any()
            np.testing.assert_allclose(
                result["equilibrium"][i, ends], np.tile(result["attractor_point"][i, row], (ends.sum(), 1)), rtol=1e-6
            )
            np.testing.assert_allclose(
                result["attractor_exponents"][i, row], result["eigenvalue_re"][i, ends][0], rtol=1e-6
            )
    lower, upper = result["attractor_point"][:, 0], result["attractor_point"][:, 1]
    np.testing.assert_allclose(lower * [-1, -1, 1], upper, atol=1e-9)


def test_starts_may_be_axes_around_parameters(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    result = open_result(run_sweep(make_sweep(LORENZ), tmp_path))
    assert result.stored.dims["attractor"] == ("x", "rho", "y")
    assert result.stored.dims["attractor_point"] == ("rho", "attractor_number", "state")
    assert "lifetime" not in result
    np.testing.assert_array_equal(result["starts"], [30, 30, 30])
    region = result["region"].transpose(1, 0, 2).reshape(3, -1)
    sink = list(result["kind"]).index("sink")
    np.testing.assert_allclose(result["basin_share"][:, sink], (region == Region.SINK).mean(axis=1))
    np.testing.assert_allclose(result["attractor_point"][0, 0], [0, 0, 0], atol=1e-9)
    number = result["attractor"][:, 1]
    np.testing.assert_array_equal(number, np.where(result["equilibrium"][:, 1, :, 0] < 0, 1, 2))
    assert not result["attractor"][:, 2].any()


def test_bytes_do_not_depend_on_tiles(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(LORENZ)
    files = [run_sweep(sweep, tmp_path / str(cells), tile_cells=cells, order_seed=cells) for cells in (7, 90)]
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_sweep_without_starts_has_no_points(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    text = LORENZ.replace("initial: {z: 20}", "initial: {x: 1, y: 1, z: 20}")
    lines = [line for line in text.splitlines() if not line.startswith(("  x:", "  y:"))]
    result = open_result(run_sweep(make_sweep("\n".join(lines)), tmp_path))
    assert "starts" not in result
    assert "attractor" not in result


def _cell(region: list[int], used: list[float], settled: list[float]) -> dict[str, np.ndarray]:
    return {
        "region": np.array(region, dtype=REGION_VARIABLE.dtype),
        "time_used": np.array(used),
        "settle_time": np.array(settled),
    }


def test_leaving_is_an_attractor_or_the_bound_and_a_saddle_does_not_count() -> None:
    nan = np.nan
    kinds = [Region.SINK, Region.PERIODIC, Region.UNBOUNDED, Region.CHAOS, Region.UNDECIDED, Region.SADDLE, Region.NONE]
    cell = _cell(kinds, [40, 50, 30, 100, 100, 100, 0], [20, 30, nan, nan, nan, nan, nan])
    survival, stayed = survival_of(cell, 10.0)
    np.testing.assert_array_equal(stayed, [2, 3, 2, 10, 10])
    np.testing.assert_array_equal(survival.at_risk, [5, 5, 5, 3, 2, 2, 2, 2, 2, 2])
    np.testing.assert_array_equal(survival.leave, [0, 0, 2, 1, 0, 0, 0, 0, 0, 0])


def test_lasting_chaos_has_a_bound_and_no_lifetime() -> None:
    cell = _cell([Region.CHAOS] * 90 + [Region.SINK] * 10, [1000.0] * 90 + [60.0] * 10, [np.nan] * 90 + [50.0] * 10)
    found = lifetimes(cell, 100, 10.0)
    assert found["chaotic_share"] == 0.9
    assert 60 <= found["lifetime_after"] <= 90
    assert np.isnan(found["lifetime"])
    assert found["lifetime_at_least"] == pytest.approx(90 * (1000 - found["lifetime_after"]) / 3.0, rel=0.05)


def _left(times: np.ndarray, look: float) -> dict[str, np.ndarray]:
    stayed = np.floor(times / look) * look
    return _cell([Region.SINK] * len(times), list(stayed + look), list(stayed))


def test_the_tail_of_direct_starts_is_no_lifetime() -> None:
    """Starts at distances that are spread over some decades spiral into a sink, as they do where chaos is not yet."""
    decay, rng = 60.0, np.random.default_rng(2)
    direct = _left(150 + decay * rng.exponential(1.2, 1024), 50.0)
    found = lifetimes(direct, 1024, 50.0, direct=300.0, decay=decay)
    assert found["chaotic_share"] > 0.01
    assert found["lifetime_after"] >= 375
    for name in ("lifetime", "lifetime_se", "lifetime_at_least", "lifetime_p"):
        assert np.isnan(found[name]), name
    assert np.isfinite(lifetimes(direct, 1024, 50.0, direct=300.0)["lifetime"])
    chaotic = _left(rng.exponential(8 * decay, 1024), 50.0)
    found = lifetimes(chaotic, 1024, 50.0, direct=300.0, decay=decay)
    assert abs(found["lifetime"] - found["lifetime_after"] - 8 * decay) < 3 * found["lifetime_se"]


def test_few_that_leave_late_have_a_bound_and_few_that_leave_early_have_none() -> None:
    sink = [60.0] * 90
    early = _left(np.array([*sink, 310.0, 320.0, 330.0]), 10.0)
    late = _left(np.array([*sink, 3100.0, 3200.0, 3300.0]), 10.0)
    assert np.isnan(lifetimes(early, 93, 10.0, direct=100.0, decay=60.0)["lifetime_at_least"])
    assert lifetimes(late, 93, 10.0, direct=100.0, decay=60.0)["lifetime_at_least"] > 600


def test_exponents_of_a_cycle_in_the_table_are_those_of_its_cells(
    tmp_path: Path, make_sweep: Callable[..., Sweep]
) -> None:
    text = """
name: cycle
model: stuart_landau
axes: {ensemble: {num: 4, seed: 1, box: {x: [0.5, 2], y: [0.5, 2]}}}
integrate: {method: rk4, dt: 0.02, duration: 400, segment: 20}
measures: {lyapunov: {exponents: 2}}
"""
    result = open_result(run_sweep(make_sweep(text), tmp_path))
    assert (result["region"] == Region.PERIODIC).all()
    assert result["attractor_kind"][0] == Certificate.CYCLE
    first = np.flatnonzero(result["attractor"] == 1)[0]
    np.testing.assert_array_equal(result["attractor_exponents"][0], result["lyapunov"][first])
    np.testing.assert_allclose(result["attractor_exponents"][0], [0, -2], atol=1e-6)
    assert result["attractor_exponents"][0, 0] != 0


def test_a_point_that_is_not_computed_has_no_numbers() -> None:
    found = lifetimes(_cell([Region.NONE] * 5, [0.0] * 5, [np.nan] * 5), 0, 10.0)
    assert all(np.isnan(value) for value in found.values())
