"""What a folder tells of its runs: an entry per start in run.json, a line per event in log.jsonl."""

from __future__ import annotations

import json
import threading
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from quavsweep.config import parse_sweep
from quavsweep.errors import LockedError, QuavsweepError, StoppedError
from quavsweep.progress import Progress
from quavsweep.sweep import run_sweep
from quavsweep.will import execute
from tests.conftest import LORENZ

SWEEP = parse_sweep(LORENZ)


def _starts(folder: Path) -> list[dict[str, Any]]:
    starts: list[dict[str, Any]] = json.loads((folder / "run.json").read_text())["starts"]
    return starts


def _events(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]


def _stop_after(tiles: int, folder: Path) -> None:
    stop = threading.Event()

    def observe(progress: Progress) -> None:
        if progress.tiles_done >= tiles:
            stop.set()

    with pytest.raises(StoppedError):
        run_sweep(SWEEP, folder, tile_cells=10, workers=1, observe=observe, stop=stop)


def test_every_start_has_an_entry_with_versions_times_and_the_reason_of_its_end(tmp_path: Path) -> None:
    _stop_after(2, tmp_path)
    run_sweep(SWEEP, tmp_path)
    first, second = _starts(tmp_path)
    assert first["reason"].startswith("stopped: stopped with 2 of 6 tiles done")
    assert second["reason"] == "complete"
    assert (first["tiles_done"], second["tiles_done"]) == (2, 6)
    for start in (first, second):
        assert {"command", "quavsweep", "python", "packages", "processor", "cores", "evidence", "toolchain"} <= set(
            start
        )
        assert datetime.fromisoformat(start["started"]) <= datetime.fromisoformat(start["ended"])


def test_a_run_that_was_killed_has_an_entry_without_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quavsweep.store.journal.Journal.__exit__", lambda *_: None)
    run_sweep(SWEEP, tmp_path)
    monkeypatch.undo()
    run_sweep(SWEEP, tmp_path)
    killed, resumed = _starts(tmp_path)
    assert "ended" not in killed
    assert resumed["reason"] == "complete"


@pytest.mark.parametrize("error", [StoppedError("the run was stopped"), LockedError("another run holds this folder")])
def test_a_stop_before_it_begins_is_a_start_and_a_refusal_is_none(
    error: QuavsweepError, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("quavsweep.sweep.make_plan", fail)
    with pytest.raises(type(error)):
        run_sweep(SWEEP, tmp_path)
    if isinstance(error, LockedError):
        assert not (tmp_path / "run.json").exists()
    else:
        assert [start["reason"] for start in _starts(tmp_path)] == ["stopped: the run was stopped"]
        assert [event["event"] for event in _events(tmp_path)] == ["start", "end"]
    monkeypatch.undo()
    run_sweep(SWEEP, tmp_path)
    assert _starts(tmp_path)[-1]["reason"] == "complete"


def test_a_process_that_ends_at_once_leaves_the_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def leave(*_: object) -> None:
        execute(5.0)
        raise SystemExit(75)

    for number, place in enumerate(("quavsweep.sweep.make_plan", "quavsweep.conductor.consolidate"), 1):
        monkeypatch.setattr(place, leave)
        with pytest.raises(SystemExit):
            run_sweep(SWEEP, tmp_path)
        monkeypatch.undo()
        starts = _starts(tmp_path)
        assert [start["reason"] for start in starts] == ["stopped: the run was stopped"] * number
        assert {"started", "ended", "command", "quavsweep"} <= set(starts[-1])
    assert [event["event"] for event in _events(tmp_path) if event["event"] != "tile"] == ["start", "end"] * 2
    execute(5.0)
    assert len(_starts(tmp_path)) == 2


def test_a_torn_line_swallows_no_other(tmp_path: Path) -> None:
    (tmp_path / "log.jsonl").write_text('{"time": "x", "ev')
    run_sweep(SWEEP, tmp_path)
    torn, *lines = (tmp_path / "log.jsonl").read_text().splitlines()
    assert torn == '{"time": "x", "ev'
    assert [json.loads(line)["event"] for line in (lines[0], lines[-1])] == ["start", "end"]


def test_the_log_has_a_line_per_event(tmp_path: Path) -> None:
    _stop_after(2, tmp_path)
    run_sweep(SWEEP, tmp_path)
    events = _events(tmp_path)
    names = [event["event"] for event in events]
    assert names == ["start", "tile", "tile", "end", "start", *["tile"] * 4, "end"]
    tiles = [event for event in events if event["event"] == "tile"]
    assert {event["tile"] for event in tiles} == set(range(6))
    assert sum(event["cells"] for event in tiles) == SWEEP.grid.size
    assert all(event["steps"] > 0 for event in tiles)


@pytest.mark.parametrize("damage", ["", "nonsense", "[]", '{"starts": 3}', '{"starts": [1]}'])
def test_nothing_depends_on_either(tmp_path: Path, damage: str) -> None:
    before = run_sweep(SWEEP, tmp_path).read_bytes()
    (tmp_path / "run.json").write_text(damage)
    (tmp_path / "log.jsonl").unlink()
    (tmp_path / "log.jsonl").mkdir()
    (tmp_path / "result.h5").unlink()
    assert run_sweep(SWEEP, tmp_path).read_bytes() == before
    assert len(_starts(tmp_path)) == 1
