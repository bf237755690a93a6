"""The tile loop: against a naive twin, every status, and nothing that depends on company."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from quavsweep.codes import Certificate, Status
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import StoppedError
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.kernels.layout import generic_frame
from quavsweep.measures import Evidence
from quavsweep.models import load_model
from quavsweep.plan import cell_values, make_plan
from tests import twin
from tests.conftest import LORENZ, YAW


def _evidence(sweep: Sweep, start: int = 0, stop: int | None = None, lanes: int = 16) -> Evidence:
    tile = Tile(0, start, sweep.grid.size if stop is None else stop)
    return integrate_tile(make_plan(sweep, lanes), tile, lambda: False)


def test_growth_equals_the_naive_twin(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(
        LORENZ,
        ("start: 0.5, stop: 600, num: 60", "values: [28]"),
        ("transient: 20, duration: 80", "transient: 2, duration: 2"),
    )
    evidence = _evidence(sweep)
    p = [10.0, 28.0, 8 / 3]
    state, growth = twin.lyapunov(
        load_model("lorenz"), [1.0, 1.0, 20.0], generic_frame(3, 3).tolist(), p, 0.02, sweep.clock.steps, 5
    )
    np.testing.assert_allclose(evidence["state"][0], state, rtol=1e-10)
    np.testing.assert_allclose(evidence["growth_total"][0, -1], growth, rtol=1e-10)
    np.testing.assert_allclose(evidence["growth"][0].sum(axis=0), growth, rtol=1e-5)


def test_cells_do_not_depend_on_tile_or_lanes(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(LORENZ)
    whole = _evidence(sweep)
    assert {Status.TIME_OVER, Status.ENDED_SINK, Status.DIVERGED} <= {Status(s) for s in whole["status"]}
    for start, stop, lanes in ((0, 1, 16), (3, 40, 32), (59, 60, 16), (17, 60, 24)):
        part = _evidence(sweep, start, stop, lanes)
        for name, values in part.items():
            np.testing.assert_array_equal(values, whole[name][start:stop], err_msg=name)
            assert values.tobytes() == whole[name][start:stop].tobytes()


def test_sinks_settle_and_end(make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("transient: 200, duration: 600", "transient: 1000, duration: 3000"))
    evidence = _evidence(sweep)
    sink = evidence["status"] == Status.ENDED_SINK
    assert sink.any()
    assert (evidence["certificate"][sink] == Certificate.SINK).all()
    assert (evidence["steps"][sink] == evidence["certified_steps"][sink]).all()
    assert (evidence["settled_steps"][sink] == evidence["steps"][sink] - sweep.clock.segment_steps).all()
    assert np.isfinite(evidence["equilibrium"][sink]).all()
    assert np.isnan(evidence["equilibrium"][~sink]).all()
    assert (evidence["eigenvalue_re"][sink] < 0).all()
    first_missing = evidence["steps"][sink] // sweep.clock.batch_steps
    for growth, batch in zip(evidence["growth"][sink], first_missing, strict=True):
        assert np.isfinite(growth[:batch]).all()
        assert np.isnan(growth[batch:]).all()


def test_stop_early_changes_nothing_but_the_time_used(make_sweep: Callable[..., Sweep]) -> None:
    change = ("transient: 200, duration: 600", "transient: 1000, duration: 3000")
    early = _evidence(make_sweep(YAW, change))
    late = _evidence(make_sweep(YAW + "stop_early: false\n", change))
    for name in ("certificate", "certified_steps", "settled_steps", "equilibrium", "eigenvalue_re", "eigenvalue_im"):
        np.testing.assert_array_equal(early[name], late[name])
    assert (late["status"] == Status.TIME_OVER).all()
    known = np.isfinite(early["growth"])
    np.testing.assert_array_equal(early["growth"][known], late["growth"][known])


def test_a_start_on_the_axis_reaches_the_saddle_and_rests(make_sweep: Callable[..., Sweep]) -> None:
    change = ("p: 0.001, q: 0.001", "p: 0, q: 0")
    evidence = _evidence(make_sweep(YAW, change, ("duration: 600", "duration: 900")))
    assert (evidence["certificate"] == Certificate.REST).all()
    assert (evidence["eigenvalue_re"][:, 0] > 0).all()
    assert (evidence["equilibrium"][:, :2] == 0).all()


def test_diverged_cells_say_so(make_sweep: Callable[..., Sweep]) -> None:
    evidence = _evidence(make_sweep(LORENZ, ("start: 0.5, stop: 600, num: 60", "values: [28, 2000]")))
    assert list(evidence["status"]) == [Status.TIME_OVER, Status.DIVERGED]
    assert np.isnan(evidence["growth"][1]).all()
    assert np.isfinite(evidence["growth"][0]).all()


def test_a_frame_that_loses_rank_is_a_status_of_its_own(make_sweep: Callable[..., Sweep]) -> None:
    """A block of 4 time units stretches Lorenz' vectors by e^62 unequally; Gram-Schmidt then sees rounding only."""
    one = ("start: 0.5, stop: 600, num: 60", "values: [28]")
    assert _evidence(make_sweep(LORENZ, one, ("block: 5", "block: 200")))["status"][0] == Status.FRAME_DEGENERATE
    assert _evidence(make_sweep(LORENZ, one, ("block: 5", "block: 50")))["status"][0] == Status.TIME_OVER


@pytest.mark.parametrize("exponents", [1, 2, 3])
def test_fewer_exponents_are_the_first_of_more(make_sweep: Callable[..., Sweep], exponents: int) -> None:
    full = _evidence(make_sweep(YAW))
    part = _evidence(make_sweep(YAW, ("exponents: 3", f"exponents: {exponents}")))
    np.testing.assert_allclose(part["growth_total"], full["growth_total"][..., :exponents], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(part["state"], full["state"])


def test_a_sweep_without_exponents_is_only_states(make_sweep: Callable[..., Sweep]) -> None:
    every = ("model: quadrotor_yaw", "model: quadrotor_yaw\nstop_early: false")
    sweep = make_sweep(YAW, ("measures: {lyapunov: {exponents: 3, block: 25}}", ""), every)
    evidence = _evidence(sweep)
    assert "growth" not in evidence
    whole = _evidence(make_sweep(YAW, ("duration: 600", f"duration: {sweep.clock.duration}"), every))
    np.testing.assert_allclose(evidence["state"], whole["state"])


def test_axes_over_initial_states_and_none(make_sweep: Callable[..., Sweep]) -> None:
    text = YAW.replace("p: 0.001, ", "").replace("c: {start: 3, stop: 7, num: 5}", "p: {values: [-1, 0, 2]}")
    parameters, u = cell_values(parse_sweep(text), Tile(0, 2, 7))
    np.testing.assert_array_equal(u[:, 0], [2, -1, 0, 2, -1])
    np.testing.assert_array_equal(parameters[0], [50, 106.25, 106.25, 106.25, 162.5])
    nothing = make_sweep(
        YAW, ("axes:\n  Omega1: {start: 50, stop: 500, num: 9}\n  c: {start: 3, stop: 7, num: 5}\n", "")
    )
    assert _evidence(nothing)["cell"].tolist() == [0]


def test_a_stop_is_answered_between_calls(make_sweep: Callable[..., Sweep]) -> None:
    asked = []

    def stopped() -> bool:
        asked.append(1)
        return len(asked) > 3

    with pytest.raises(StoppedError):
        integrate_tile(make_plan(make_sweep(YAW), 16), Tile(0, 0, 45), stopped)
    assert len(asked) == 4


@pytest.mark.parametrize("dimension", [1, 2, 3, 12])
def test_the_first_frame_is_orthonormal_and_generic(dimension: int) -> None:
    frame = generic_frame(dimension, dimension)
    np.testing.assert_allclose(frame @ frame.T, np.eye(dimension), atol=1e-14)
    if dimension > 1:
        assert (np.abs(frame) > 1e-3).all()
