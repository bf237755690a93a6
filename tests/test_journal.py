"""What a folder tells of its runs: an entry per start in run.json, a line per event in log.jsonl."""

from __future__ import annotations

import json
import threading
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from quavsweep.config import parse_sweep
from quavsweep.errors import StoppedError
from quavsweep.progress import Progress
from quavsweep.sweep import run_sweep
from tests.conftest import LORENZ

SWEEP = parse_sweep(LORENZ)


def _starts(folder: Path) -> list[dict[str, Any]]:
    starts: list[dict[str, Any]] = json.loads((folder / "run.json").read_text())["starts"]
    return starts


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


def test_the_log_has_a_line_per_event(tmp_path: Path) -> None:
    _stop_after(2, tmp_path)
    run_sweep(SWEEP, tmp_path)
    events = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
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
