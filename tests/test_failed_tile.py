"""Tiles that raise: the others are done, a record says why, and nobody tries them again unasked."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import quavsweep.work
from quavsweep.cli import main
from quavsweep.codes import Status
from quavsweep.config import parse_sweep
from quavsweep.errors import StoppedError, TilesFailedError
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.measures import Evidence
from quavsweep.overview import Lookout
from quavsweep.plan import Plan
from quavsweep.result import open_result
from quavsweep.sweep import reclassify, run_sweep
from tests.conftest import LORENZ

SWEEP = parse_sweep(LORENZ)
CELLS = 10  # per tile, of six


@pytest.fixture
def odd(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Let the tile of number 2 raise; return the numbers of the tiles that were begun."""
    begun: list[int] = []

    def sometimes(plan: Plan, tile: Tile, stopped: Callable[[], bool]) -> Evidence:
        begun.append(tile.index)
        if tile.index == 2:
            raise ValueError("something odd")
        return integrate_tile(plan, tile, stopped)

    monkeypatch.setattr(quavsweep.work, "integrate_tile", sometimes)
    return begun


def _run(folder: Path, **options: bool) -> None:
    run_sweep(SWEEP, folder, tile_cells=CELLS, **options)  # type: ignore[arg-type]


def _failed(folder: Path) -> np.ndarray:
    return np.flatnonzero(open_result(folder)["status"] == Status.FAILED)


def test_the_others_are_in_the_result_and_a_record_holds_the_traceback(tmp_path: Path, odd: list[int]) -> None:
    with pytest.raises(TilesFailedError, match="1 of 6 tiles raised, the first with ValueError: something odd") as told:
        _run(tmp_path)
    assert "--retry-failed" in str(told.value)
    assert _failed(tmp_path).tolist() == list(range(20, 30))
    [record] = tmp_path.glob("failed/*/*/tile-*.txt")
    text = record.read_text()
    assert text.startswith("tile 2, cells 20 to 29: ValueError: something odd\nTraceback")
    assert "integrate_tile" in text or "sometimes" in text
    assert Lookout.of(tmp_path).look().failed == 10


def test_a_tile_that_raised_is_left_out_until_asked_for(
    tmp_path: Path, odd: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    for _ in range(2):
        with pytest.raises(TilesFailedError):
            _run(tmp_path)
    assert odd.count(2) == 1
    monkeypatch.setattr(quavsweep.work, "integrate_tile", integrate_tile)
    with pytest.raises(TilesFailedError):
        _run(tmp_path)
    _run(tmp_path, retry_failed=True)
    assert not _failed(tmp_path).size
    assert not list(tmp_path.glob("failed/*/*/tile-*.txt"))
    run_sweep(SWEEP, tmp_path / "undisturbed", tile_cells=CELLS)
    assert (tmp_path / "result.h5").read_bytes() == (tmp_path / "undisturbed" / "result.h5").read_bytes()


def test_fail_fast_ends_the_run_without_a_result(tmp_path: Path, odd: list[int]) -> None:
    with pytest.raises(TilesFailedError, match="the run ended with it"):
        _run(tmp_path, fail_fast=True)
    assert not (tmp_path / "result.h5").exists()
    assert list(tmp_path.glob("failed/*/*/tile-*.txt"))


def test_fail_fast_leaves_the_tiles_in_flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    left: list[int] = []

    def waiting(plan: Plan, tile: Tile, stopped: Callable[[], bool]) -> Evidence:
        if tile.index == 2:
            raise ValueError("something odd")
        for _ in range(1000):
            if stopped():
                left.append(tile.index)
                raise StoppedError("left")
            time.sleep(0.01)
        raise AssertionError("nobody said so")

    monkeypatch.setattr(quavsweep.work, "integrate_tile", waiting)
    with pytest.raises(TilesFailedError, match="ended with it"):
        run_sweep(SWEEP, tmp_path, tile_cells=CELLS, workers=6, fail_fast=True)
    assert len(left) == 5


def test_an_error_of_several_lines_is_told_in_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_: object) -> None:
        raise ValueError("something\nodd: \u00e4\n")

    monkeypatch.setattr(quavsweep.work, "integrate_tile", failing)
    for _ in range(2):  # then as the record tells it
        with pytest.raises(TilesFailedError, match="the first with ValueError: something odd: \u00e4; "):
            _run(tmp_path)
    events = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert {e["error"] for e in events if e["event"] == "failed"} == {"ValueError: something odd: \u00e4"}


def test_records_from_elsewhere_are_read_in_part_and_by_no_other_name(tmp_path: Path, odd: list[int]) -> None:
    with pytest.raises(TilesFailedError):
        _run(tmp_path)
    [record] = tmp_path.glob("failed/*/*/tile-*.txt")
    with record.open("r+b") as file:
        file.truncate(2**33)
    record.with_name("tile-0000003.10.txt").symlink_to("/etc/hostname")
    os.mkfifo(record.with_name("tile-0000004.10.txt"))
    (tmp_path / "result.h5").unlink()
    assert Lookout.of(tmp_path).look().failed == 10


def test_thresholds_can_change_where_tiles_raised(tmp_path: Path, odd: list[int]) -> None:
    with pytest.raises(TilesFailedError):
        _run(tmp_path)
    reclassify(tmp_path, ["classify.errors=4"])
    assert _failed(tmp_path).size == 10


def test_the_command_ends_with_3_and_says_where_to_look(
    tmp_path: Path, odd: list[int], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "lorenz.yaml"
    config.write_text(LORENZ)
    monkeypatch.setattr("quavsweep.sweep.choose_tile_cells", lambda plan: CELLS)
    for extra in ([], ["--fail-fast", "--retry-failed"]):
        command = ["quavsweep", "run", str(config), "--out", str(tmp_path / "out"), "--no-plot", *extra]
        monkeypatch.setattr(sys, "argv", command)
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 3
        assert "1 of 6 tiles raised" in capsys.readouterr().err
