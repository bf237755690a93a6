"""The paper: verdicts follow from numbers alone, what fails is named, and nothing that it prints is missing."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from quavsweep.errors import ConfigError, IdentityError, StoppedError
from quavsweep.paper import conductor, figure_03, reproduce_paper, table_3
from quavsweep.paper.catalogue import ITEMS
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.outcome import analysed
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed, Printed, Row, Verdict
from quavsweep.paper.run import Runs, config_path

EVERY = [printed for item in ITEMS for printed in read_printed(item.name)]


def _row(paper: str, value: float | str, error: float = 0.0, reason: str = "") -> Row:
    return Row(Printed("k", "Section 1", "what", paper, "s", reason), Computed(value, error))


@pytest.mark.parametrize(
    ("paper", "value", "error", "verdict"),
    [
        ("6.3852", 6.385194, 0.0, Verdict.AGREES),
        ("6.3852", 6.38526, 0.0, Verdict.DIFFERS),
        ("-0.05", -0.0500004, 0.0, Verdict.AGREES),
        ("2.9e-5", 2.94e-5, 0.0, Verdict.AGREES),
        ("2.9e-5", 2.96e-5, 0.0, Verdict.DIFFERS),
        ("0.040392", 0.0412, 0.0005, Verdict.WITHIN),
        ("147", 152.2, 0.2, Verdict.DIFFERS),
        ("chaos", "chaos", 0.0, Verdict.AGREES),
        ("chaos", "sink", 0.0, Verdict.DIFFERS),
    ],
)
def test_a_verdict_follows_from_digits_value_and_error(
    paper: str, value: float | str, error: float, verdict: Verdict
) -> None:
    row = _row(paper, value, error, "because")
    assert row.verdict is verdict
    assert bool(row.reason) is (verdict is Verdict.DIFFERS)
    assert Row(row.printed, None).verdict is Verdict.MISSING


@pytest.mark.parametrize("printed", [p for p in EVERY if p.number], ids=lambda p: p.key)
def test_two_percent_turn_a_verdict(printed: Printed) -> None:
    number = printed.number
    assert number is not None
    if abs(float(number)) * 0.02 <= printed.half_unit:
        pytest.skip("printed with too few digits to see two percent")
    assert Row(printed, Computed(float(number))).verdict is Verdict.AGREES
    assert Row(printed, Computed(1.02 * float(number) * (1.0 + 1e-12))).verdict is Verdict.DIFFERS


@pytest.mark.parametrize("item", [figure_03.FIGURE, table_3.FIGURE], ids=lambda item: item.name)
def test_two_percent_more_turn_what_was_computed(item: Item, tmp_path: Path) -> None:
    found = analysed(item, Runs(tmp_path)).computed
    turned = 0
    for printed in read_printed(item.name):
        computed, number = found[printed.key], printed.number
        row = Row(printed, computed)
        if number is None or row.verdict is not Verdict.AGREES or abs(float(number)) * 0.02 <= 2 * printed.half_unit:
            continue
        assert isinstance(computed.value, float)
        assert Row(printed, replace(computed, value=1.02 * computed.value)).verdict is Verdict.DIFFERS, printed.key
        turned += 1
    assert turned


def test_what_is_taken_as_given_does_not_agree() -> None:
    printed = Printed("k", "Section 1", "what", "4.9e-3")
    assert Row(printed, Computed(4.9e-3, given=True)).verdict is Verdict.GIVEN
    assert Row(printed, Computed(5.9e-3, given=True)).verdict is Verdict.DIFFERS


def test_items_have_names_of_their_own_and_their_configs_exist() -> None:
    assert len({item.name for item in ITEMS}) == len(ITEMS)
    for item in ITEMS:
        assert item.title
        assert not item.title.endswith(".")
        for name in item.configs:
            assert config_path(name).is_file()
    with pytest.raises(ConfigError, match="no config figure_99"):
        config_path("figure_99")


def _items(monkeypatch: pytest.MonkeyPatch, *items: Item) -> None:
    monkeypatch.setattr(conductor, "ITEMS", items)


def _nothing(runs: Runs) -> Findings:
    return Findings(text="Nothing was computed.")


def _wrong(runs: Runs) -> Findings:
    raise ValueError("a bug in an analysis")


def _stopped(runs: Runs) -> Findings:
    raise StoppedError("stopped")


def test_what_fails_is_named_and_the_rest_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _items(monkeypatch, Item("bad", "Bad", _wrong), Item("good", "Good", _nothing, lambda runs, findings: Figure()))
    done = reproduce_paper(tmp_path / "paper")
    assert [outcome.item.name for outcome in done.failed] == ["bad"]
    assert "a bug in an analysis" in (tmp_path / "paper/failed/bad.txt").read_text()
    assert (tmp_path / "paper/figures/good.png").stat().st_size
    report = (tmp_path / "paper/report.md").read_text()
    assert "**Failed: ValueError: a bug in an analysis**" in report
    assert "Nothing was computed." in report
    data = json.loads((tmp_path / "paper/report.json").read_text())
    assert [item["item"] for item in data["items"]] == ["bad", "good"]


def test_runs_that_an_analysis_makes_are_named_with_their_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = {"margin_case_1": {"margin/case_1/region/probe-1": "0123456789abcdef"}}
    _items(monkeypatch, Item("good", "Good", lambda runs: Findings(sources=made)))
    reproduce_paper(tmp_path / "paper")
    assert "Computed from `margin_case_1.yaml` (1 runs)" in (tmp_path / "paper/report.md").read_text()
    data = json.loads((tmp_path / "paper/report.json").read_text())
    assert data["items"][0]["results"] == made["margin_case_1"]


def test_items_done_earlier_stay_in_the_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one, two = (Item(name, name.title(), _nothing, lambda runs, findings: Figure()) for name in ("one", "two"))
    _items(monkeypatch, one, two)
    reproduce_paper(tmp_path / "paper")
    whole = (tmp_path / "paper/report.md").read_bytes()
    reproduce_paper(tmp_path / "paper", only=["two"])
    assert (tmp_path / "paper/report.md").read_bytes() == whole
    _items(monkeypatch, Item("one", "One", _wrong), two)
    assert reproduce_paper(tmp_path / "paper", only=["one"]).failed
    assert (tmp_path / "paper/failed/one.txt").exists()
    _items(monkeypatch, one, two)
    reproduce_paper(tmp_path / "paper", only=["one"])
    assert not (tmp_path / "paper/failed/one.txt").exists()
    assert (tmp_path / "paper/report.md").read_bytes() == whole


def test_a_stop_is_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _items(monkeypatch, Item("bad", "Bad", _stopped))
    with pytest.raises(StoppedError):
        reproduce_paper(tmp_path / "paper", stop=threading.Event())


def test_a_foreign_folder_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _items(monkeypatch, Item("good", "Good", _nothing))
    (tmp_path / "mine").mkdir()
    reproduce_paper(tmp_path / "mine")
    reproduce_paper(tmp_path / "mine")
    with pytest.raises(IdentityError, match="the whole paper"):
        reproduce_paper(tmp_path / "mine", quick=True)
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs/notes.txt").write_text("notes")
    with pytest.raises(IdentityError, match="something else"):
        reproduce_paper(tmp_path / "theirs")
    command = [sys.executable, "-m", "quavsweep", "paper", "--out", str(tmp_path / "theirs")]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 4


def test_an_unknown_item_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no figure_99"):
        reproduce_paper(tmp_path / "paper", only=["figure_99"])
    assert not (tmp_path / "paper").exists()
