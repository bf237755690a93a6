"""Sweeps that keep no evidence: the same result from shards of a fraction of the size, and what cannot be done then."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

import quavsweep.work
from quavsweep.codes import Region, Status
from quavsweep.config import Sweep, parse_sweep
from quavsweep.content import content_bytes
from quavsweep.errors import ConfigError, IdentityError, QuavsweepError, StoppedError, TilesFailedError
from quavsweep.overview import Lookout
from quavsweep.plan import Plan, make_plan
from quavsweep.preview import preview_run
from quavsweep.provenance import identify
from quavsweep.result import open_result
from quavsweep.store import RunFolder, ShardSet, Stored, check_result
from quavsweep.sweep import extend_sweep, reclassify, run_sweep
from quavsweep.verify import verify_folder
from quavsweep.work import Errand, Order
from tests.conftest import LORENZ, YAW
from tests.test_ensemble import ENSEMBLE

SUMMARY = "\nevidence: summary\n"
SAMPLED = YAW.replace("block: 25}", "block: 25}, samples: {maxima: p, max: 9}, statistics: {of: [p]}")
SWEEPS = {"yaw": SAMPLED, "lorenz": LORENZ, "ensemble": ENSEMBLE}
TOLD = {"config", "evidence_id", "result_id", "content_sha256"}  # attributes that say which config it was


def _chunks(path: Path) -> dict[str, object]:
    with h5py.File(path) as file:
        return {name: (file[name].chunks, file[name].id.get_storage_size()) for name in file}


def _assert_same(one: Stored, other: Stored) -> None:
    assert one.dims == other.dims
    for name in one.dims:
        assert one.data[name].dtype == other.data[name].dtype
        assert one.data[name].tobytes() == other.data[name].tobytes() or one.data[name].dtype.kind == "O", name
        for key, value in one.attributes[name].items():
            np.testing.assert_array_equal(value, other.attributes[name][key])
    changed = {k for k in one.file_attributes if one.file_attributes[k] != other.file_attributes[k]}
    assert one.file_attributes.keys() == other.file_attributes.keys()
    assert changed == TOLD


@pytest.mark.parametrize("name", SWEEPS)
def test_the_result_is_that_of_full_evidence(name: str, tmp_path: Path) -> None:
    full = run_sweep(parse_sweep(SWEEPS[name]), tmp_path / "full", tile_cells=32)
    summary = run_sweep(parse_sweep(SWEEPS[name] + SUMMARY), tmp_path / "summary", tile_cells=20)
    _assert_same(check_result(full), check_result(summary))
    assert _chunks(full) == _chunks(summary)
    assert verify_folder(tmp_path / "summary").damaged == ()


def test_bytes_do_not_depend_on_tiles_or_kills(tmp_path: Path) -> None:
    sweep, stop = parse_sweep(SAMPLED + SUMMARY), threading.Event()
    with pytest.raises(StoppedError):
        run_sweep(
            sweep, tmp_path / "a", tile_cells=16, stop=stop, observe=lambda p: stop.set() if p.cells_run else None
        )
    first = next((tmp_path / "a").glob("shards/*/*/*/*.h5"))
    first.write_bytes(first.read_bytes()[:-1] + b"x")
    a = run_sweep(sweep, tmp_path / "a")
    b = run_sweep(sweep, tmp_path / "b", tile_cells=45, lanes=32, workers=1)
    assert a.read_bytes() == b.read_bytes()


def test_a_shard_holds_what_the_result_needs_and_no_more(tmp_path: Path) -> None:
    sweeps = [parse_sweep(YAW), parse_sweep(YAW + SUMMARY)]
    sizes = []
    for sweep in sweeps:
        out = tmp_path / sweep.config.evidence
        planned = preview_run(sweep, out).shard_bytes
        run_sweep(sweep, out, tile_cells=45)
        (shard,) = out.glob("shards/*/*/*/*.h5")
        assert planned == sweep.grid.size * content_bytes(sweep) <= shard.stat().st_size
        with h5py.File(shard) as file:
            sizes.append((set(file), planned))
    (full, large), (summary, small) = sizes
    assert {"growth", "growth_total", "frame", "divergence", "state", "steps"} <= full - summary
    assert summary == {"cell", *open_result(tmp_path / "summary").variables}
    assert small < large / 3


def test_evidence_keeps_its_identity(make_sweep: Callable[..., Sweep]) -> None:
    full, summary = parse_sweep(YAW), parse_sweep(YAW + SUMMARY)
    ids = {identify(parse_sweep(text)).evidence for text in (YAW, YAW + "\nclassify: {errors: 4}\n")}
    assert ids == {identify(full).evidence}
    ids = {
        identify(parse_sweep(YAW.replace(*change) + SUMMARY + rules)).evidence
        for change in (("", ""), ("duration: 600", "duration: 900"))
        for rules in ("", "classify: {errors: 4}")
    }
    assert len(ids) == 4
    assert not ids & {identify(full).evidence}
    assert full.canonical()["evidence"] == "full"
    assert summary.canonical()["evidence"] == "summary"


def test_what_needs_evidence_is_refused(tmp_path: Path) -> None:
    sweep = parse_sweep(YAW + SUMMARY)
    before = run_sweep(sweep, tmp_path).read_bytes()
    refused: dict[str, Callable[[], object]] = {
        "classify": lambda: reclassify(tmp_path, ["classify.errors=4"]),
        "extend": lambda: extend_sweep(tmp_path, 900),
        "a horizon": lambda: open_result(tmp_path, 500.0),
        "effort": lambda: parse_sweep(YAW + SUMMARY + "effort: {max_duration: 1200}"),
    }
    for what, call in refused.items():
        with pytest.raises(ConfigError, match=f"{what}.* needs evidence: full") as caught:
            call()
        assert caught.value.exit_code == 2
    assert (tmp_path / "result.h5").read_bytes() == before


@pytest.mark.parametrize("finished", [True, False])
def test_other_thresholds_are_refused(finished: bool, tmp_path: Path) -> None:
    result = run_sweep(parse_sweep(YAW + SUMMARY), tmp_path)
    if not finished:
        result.unlink()
    with pytest.raises(IdentityError, match=r"classify.errors: 3.0 there, 4.0 here; .*so they cannot change"):
        run_sweep(parse_sweep(YAW + SUMMARY + "classify: {errors: 4}"), tmp_path)
    with pytest.raises(IdentityError, match="evidence: summary there, full here"):
        run_sweep(parse_sweep(YAW), tmp_path)
    with pytest.raises(IdentityError, match=r"integrate.duration"):
        run_sweep(parse_sweep(YAW.replace("duration: 600", "duration: 900") + SUMMARY), tmp_path)


def test_an_edited_config_does_not_relabel(tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW + SUMMARY), tmp_path).unlink()
    config = tmp_path / "config.yaml"
    config.write_text(config.read_text().replace("errors: 3.0", "errors: 4.0"))
    with pytest.raises(IdentityError, match="made with another config"):
        open_result(tmp_path)


def test_an_unfinished_folder_can_be_looked_at(tmp_path: Path) -> None:
    whole = open_result(run_sweep(parse_sweep(YAW + SUMMARY), tmp_path, tile_cells=16))
    (tmp_path / "result.h5").unlink()
    next(tmp_path.glob("shards/*/*/*/tile-0000001*")).unlink()
    part = open_result(tmp_path)
    done = part["region"] != Region.NONE
    assert done.sum() == 29
    np.testing.assert_array_equal(part["lyapunov"][done], whole["lyapunov"][done])
    assert np.isnan(part["lyapunov"][~done]).all()
    overview = Lookout.of(tmp_path).look()
    assert overview.looked_at == sum(overview.regions.values()) == 29


def test_failed_tiles_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = quavsweep.work.integrate_tile

    def fails(plan: Plan, tile: object, stopped: Callable[[], bool]) -> object:
        if getattr(tile, "index", 0) == 1:
            raise ValueError("no")
        return real(plan, tile, stopped)  # type: ignore[arg-type]

    results = []
    for text in (YAW, YAW + SUMMARY):
        folder = tmp_path / parse_sweep(text).config.evidence
        monkeypatch.setattr(quavsweep.work, "integrate_tile", fails)
        with pytest.raises(TilesFailedError):
            run_sweep(parse_sweep(text), folder, tile_cells=16)
        results.append(check_result(folder / "result.h5"))
    assert (results[1].data["status"] == Status.FAILED).sum() == 16
    _assert_same(*results)


def test_a_worker_finds_a_shard_again(tmp_path: Path) -> None:
    sweep = parse_sweep(YAW + SUMMARY)
    result = open_result(run_sweep(sweep, tmp_path, tile_cells=45))
    shards = ShardSet.scan(RunFolder(tmp_path), sweep, identify(sweep))
    order = Order.of(make_plan(sweep, 16), shards, tmp_path)
    done = Errand(order, shards.tile(0), check=True)(lambda: False)
    assert done.shards == list(shards)
    assert done.steps == 0
    np.testing.assert_array_equal(done.regions, np.bincount(result["region"].ravel(), minlength=len(done.regions)))


def test_effort_names_both_keys() -> None:
    with pytest.raises(QuavsweepError, match=r"config:\d+: effort: needs evidence: full, but evidence \(line \d+\) is"):
        parse_sweep(YAW + SUMMARY + "effort: {max_duration: 1200}")
