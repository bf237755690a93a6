"""Runs that go on: from checkpoints to a later end, and by passes where cells are undecided, to the same bytes."""

import threading
from pathlib import Path

import numpy as np
import pytest

from quavsweep.codes import Region, Status
from quavsweep.config import parse_sweep
from quavsweep.errors import ConfigError, IdentityError, StoppedError
from quavsweep.grid import Tile
from quavsweep.integrate import continue_cells, integrate_tile
from quavsweep.plan import make_plan
from quavsweep.preview import preview_run
from quavsweep.result import open_result
from quavsweep.store import RunFolder
from quavsweep.sweep import extend_sweep, reclassify, run_sweep

YAW = """
name: stage
model: quadrotor_yaw
initial: {p: 0.001, q: 0.001, r: 0.001}
axes:
  Omega1: {start: 100, stop: 260, num: 9}
  c: {start: 3, stop: 7, num: 5}
integrate: {dt: 0.02, transient: 200, duration: 600}
measures:
  lyapunov: {exponents: 3, block: 25, batch: 12.5}
  samples: {maxima: p, max: 30}
"""
EFFORT = "\neffort: {max_duration: 2400}\n"


def _longer(text: str, duration: int) -> str:
    return text.replace("duration: 600", f"duration: {duration}")


@pytest.mark.parametrize("measures", ["lyapunov: {block: 25, batch: 12.5}", "verdict: {batches: 8}"])
def test_cells_that_go_on_have_the_bits_of_one_run(measures: str) -> None:
    text = (
        YAW.partition("measures:")[0] + "  segment: 50\n".replace("  segment: 50\n", "") + f"measures: {{{measures}}}"
    )
    text = text.replace("duration: 600}", "duration: 600, segment: 50}")
    longer = make_plan(parse_sweep(_longer(text, 1000)), 16)
    tile = Tile(0, 0, 45)
    begun = integrate_tile(make_plan(parse_sweep(text), 16), tile, lambda: False)
    whole = integrate_tile(longer, tile, lambda: False)
    for name, values in continue_cells(longer, begun, lambda: False).items():
        np.testing.assert_array_equal(values, whole[name], err_msg=name)


def test_an_extended_run_equals_a_longer_one_to_the_byte(tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW), tmp_path / "short", tile_cells=32)
    extended = extend_sweep(tmp_path / "short", 1400)
    whole = run_sweep(parse_sweep(_longer(YAW, 1400)), tmp_path / "long", tile_cells=20)
    assert extended.read_bytes() == whole.read_bytes()
    assert (tmp_path / "short" / "config.yaml").read_bytes() == (tmp_path / "long" / "config.yaml").read_bytes()


@pytest.mark.parametrize("measure", ["orbit: {every: 5}", "peak: {of: [p, r]}", "first_time: {of: p, above: 3}"])
@pytest.mark.parametrize("sizes", [{}, {"until": 300}])
def test_measures_that_look_to_the_end_look_on(measure: str, sizes: dict[str, int], tmp_path: Path) -> None:
    text = YAW.replace(
        "samples: {maxima: p, max: 30}", measure.replace("}", "".join(f", {k}: {v}" for k, v in sizes.items()) + "}")
    )
    run_sweep(parse_sweep(text), tmp_path / "short")
    extended = extend_sweep(tmp_path / "short", 900)
    assert extended.read_bytes() == run_sweep(parse_sweep(_longer(text, 900)), tmp_path / "long").read_bytes()


def test_cycles_end_with_their_samples(tmp_path: Path) -> None:
    result = open_result(run_sweep(parse_sweep(YAW), tmp_path))
    ended = result["status"] == Status.ENDED_CYCLE
    assert ended.any()
    assert (result["sample_count"][ended] >= 30).all()
    assert (result["time_used"][ended] < 800).any()


def test_effort_keeps_the_shape_of_an_orbit_and_is_raised_by_an_extension(tmp_path: Path) -> None:
    text = YAW.replace("samples: {maxima: p, max: 30}", "orbit: {every: 5, until: 700}") + EFFORT
    short = open_result(run_sweep(parse_sweep(text), tmp_path))
    assert short["orbit"].shape == (9, 5, 141, 3)
    longer = open_result(extend_sweep(tmp_path, 3000))
    assert longer.sweep.config.effort is not None
    assert longer.sweep.config.effort.max_duration == 3000


def test_a_stopped_extension_goes_on(tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW), tmp_path / "short", tile_cells=16)
    stop = threading.Event()
    with pytest.raises(StoppedError):
        extend_sweep(
            tmp_path / "short", 1400, workers=1, stop=stop, observe=lambda p: stop.set() if p.cells_run else None
        )
    for shard in list((tmp_path / "short").glob("shards/*/*/0-*/tile-0000001*")):
        shard.write_bytes(shard.read_bytes()[:-1] + b"x")  # its tile begins anew
    extended = extend_sweep(tmp_path / "short", 1400)
    whole = run_sweep(parse_sweep(_longer(YAW, 1400)), tmp_path / "long")
    assert extended.read_bytes() == whole.read_bytes()


def test_a_run_cannot_be_shortened_and_its_old_config_is_refused(tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW), tmp_path)
    with pytest.raises(ConfigError, match="at least 600; plot --horizon"):
        extend_sweep(tmp_path, 500)
    extend_sweep(tmp_path, 700)
    with pytest.raises(IdentityError, match=r"integrate\.duration"):
        run_sweep(parse_sweep(YAW), tmp_path)


def test_undecided_cells_go_on_and_the_others_stay(tmp_path: Path) -> None:
    plain = open_result(run_sweep(parse_sweep(YAW), tmp_path / "plain"))
    effort = open_result(run_sweep(parse_sweep(YAW + EFFORT), tmp_path / "effort", tile_cells=16))
    open_cells = plain["region"] == Region.UNDECIDED
    assert open_cells.any()
    for name in ("region", "lyapunov", "final_state", "time_used"):
        np.testing.assert_array_equal(effort[name][~open_cells], plain[name][~open_cells])
    assert (effort["time_used"][open_cells] > 800).all()
    assert (effort["region"] == Region.UNDECIDED).sum() < open_cells.sum()
    end = parse_sweep(_longer(YAW, 2400))
    longest = open_result(run_sweep(end, tmp_path / "longest"))
    still = effort["time_used"] == longest["time_used"].max()
    np.testing.assert_array_equal(effort["final_state"][still], longest["final_state"][still])


def test_effort_gives_the_same_bytes_for_any_history(tmp_path: Path) -> None:
    sweep = parse_sweep(YAW + EFFORT)
    first = run_sweep(sweep, tmp_path / "a", tile_cells=16)
    second = run_sweep(sweep, tmp_path / "b", tile_cells=45, workers=1, lanes=32)
    assert first.read_bytes() == second.read_bytes()
    passes = sorted((tmp_path / "a").glob("shards/*/*/*/*.cells-*"))
    assert passes
    passes[0].unlink()
    passes[-1].write_bytes(passes[-1].read_bytes()[:-1] + b"x")
    assert run_sweep(sweep, tmp_path / "a").read_bytes() == second.read_bytes()


def test_effort_added_later_goes_on_from_what_is_there(tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW), tmp_path / "a")
    present = set(RunFolder(tmp_path / "a").path.glob("shards/*/*/*/*"))
    later = run_sweep(parse_sweep(YAW + EFFORT), tmp_path / "a")
    assert present < set(RunFolder(tmp_path / "a").path.glob("shards/*/*/*/*"))
    assert later.read_bytes() == run_sweep(parse_sweep(YAW + EFFORT), tmp_path / "b").read_bytes()


def test_thresholds_that_make_other_cells_undecided_ask_for_a_run(tmp_path: Path) -> None:
    sweep = parse_sweep(YAW + EFFORT)
    run_sweep(sweep, tmp_path / "a")
    with pytest.raises(StoppedError, match="have not gone on yet"):
        reclassify(tmp_path / "a", ["classify.errors=30"])
    changed = parse_sweep(YAW + EFFORT, changes=["classify.errors=30"])
    assert run_sweep(changed, tmp_path / "a").read_bytes() == run_sweep(changed, tmp_path / "b").read_bytes()


BOTH = "effort: {max_duration: 2400, of: [chaos, undecided]}\n"


def test_chaos_goes_on_as_well_and_a_horizon_is_the_plain_run(tmp_path: Path) -> None:
    text = _longer(YAW, 600).replace("num: 9", "num: 30")
    plain = open_result(run_sweep(parse_sweep(text), tmp_path / "plain"))
    run_sweep(parse_sweep(text + BOTH), tmp_path / "both", tile_cells=16)
    both, seen = open_result(tmp_path / "both"), open_result(tmp_path / "both", 800.0)
    went = np.isin(plain["region"], (Region.UNDECIDED, Region.CHAOS))
    assert (plain["region"] == Region.CHAOS).any()
    assert (both["time_used"][went] > 800).all()
    for name in ("region", "lyapunov", "lyapunov_se", "time_used", "was_chaotic", "chaotic_until", "final_state"):
        np.testing.assert_array_equal(seen[name], plain[name])
        np.testing.assert_array_equal(both[name][~went], plain[name][~went])
    longest = open_result(run_sweep(parse_sweep(_longer(text, 2400)), tmp_path / "longest"))
    last = both["time_used"] == longest["time_used"].max()
    assert (both["region"] == Region.CHAOS).any()
    assert set(both["time_used"][both["region"] == Region.CHAOS]) == {longest["time_used"].max()}
    np.testing.assert_array_equal(both["final_state"][last], longest["final_state"][last])
    again = run_sweep(parse_sweep(text + BOTH), tmp_path / "again", tile_cells=45, workers=1)
    assert again.read_bytes() == (tmp_path / "both" / "result.h5").read_bytes()


def test_of_names_each_region_once() -> None:
    effort = parse_sweep(YAW + BOTH).config.effort
    assert effort is not None
    assert effort.of == ["undecided", "chaos"]
    default = parse_sweep(YAW + EFFORT).config.effort
    assert default is not None
    assert default.of == ["undecided"]
    with pytest.raises(
        ConfigError, match=r"effort.of \(item 1\): 'sink' is not accepted; it should be undecided or chaos"
    ):
        parse_sweep(YAW + BOTH.replace("chaos", "sink"))


def test_a_damaged_shard_of_an_earlier_stage_takes_no_tile_away(tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW), tmp_path, tile_cells=45)
    extend_sweep(tmp_path, 900)
    earlier = next(iter(tmp_path.glob("shards/*/*/0-*/tile-*")))
    data = bytearray(earlier.read_bytes())
    data[len(data) // 2] ^= 1
    earlier.write_bytes(data)
    preview = preview_run(parse_sweep(_longer(YAW, 900)), tmp_path)
    assert (preview.valid, preview.missing, len(preview.bad)) == (1, 0, 1)
