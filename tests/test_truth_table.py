"""The table of truth: its command line, how rows are told and recorded, and that rows work with small numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.truth import __main__ as table
from tests.truth.catalogue import ROWS, select
from tests.truth.laboratory import Laboratory
from tests.truth.report import record, summed_up, told
from tests.truth.row import Claim, Outcome, Row


def _row(*holds: bool | None) -> Row:
    claims = [
        Claim("asked for", "measured as", h, "of this", {"x": np.float64("nan"), "n": np.arange(2)}) for h in holds
    ]
    return Row("some", "some row", "1 s", lambda _: claims)


def test_list_names_every_row(capsys: pytest.CaptureFixture[str]) -> None:
    assert table.main(["--list"]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert listed == [row.key for row in ROWS]
    assert len(set(listed)) == len(listed)


def test_an_unknown_row_is_exit_2_with_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert table.main(["coverage", "covrage"]) == 2
    message = capsys.readouterr().err
    assert "covrage" in message
    assert all(row.key in message for row in ROWS)


def test_rows_are_named_by_their_beginning() -> None:
    assert [row.key for row in select(["coverage", "horizon"])] == ["coverage-lorenz", "coverage-yaw", "horizon"]
    assert select([]) == list(ROWS)


@pytest.mark.parametrize(
    ("holds", "expected"), [((True, None), True), ((True, False), False), ((None,), True), ((np.bool_(False),), False)]
)
def test_a_row_holds_if_none_of_its_claims_is_missed(holds: tuple[bool | None, ...], expected: bool) -> None:
    outcome = table.run(_row(*holds), Laboratory(Path("nowhere")))
    assert outcome.holds is expected
    assert ("MISSED" in told(outcome)) is not expected
    assert summed_up([outcome]).startswith("1 of 1" if expected else "0 of 1")


def test_an_error_is_a_row_that_is_missed(capsys: pytest.CaptureFixture[str]) -> None:
    def raises(_: Laboratory) -> list[Claim]:
        raise ValueError("no such thing")

    outcome = table.run(Row("some", "some row", "1 s", raises), Laboratory(Path("nowhere")))
    assert not outcome.holds
    assert "ValueError: no such thing" in told(outcome)
    assert "ValueError" in capsys.readouterr().err


def test_the_record_is_json_with_all_numbers() -> None:
    outcome = Outcome(
        _row(), [Claim("a", "b", True, "c", {"x": np.float64("nan"), "n": np.arange(2), "z": 1 + 2j})], 1.0
    )
    row = json.loads(json.dumps(record([outcome], quick=True)))["rows"][0]
    assert row["claims"][0]["numbers"] == {"x": None, "n": [0, 1], "z": [1.0, 2.0]}
    assert row["holds"] is True


def test_a_cheap_row_works(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "truth.json"
    code = table.main(["extend", "--quick", "--out", str(tmp_path), "--json", str(file)])
    out = capsys.readouterr().out
    assert code == 0, out
    assert "equals the long run to the byte" in out
    assert json.loads(file.read_text())["rows"][0]["key"] == "extend"


@pytest.mark.slow
@pytest.mark.parametrize("key", [row.key for row in ROWS])
def test_each_row_works_with_small_numbers(key: str, tmp_path: Path) -> None:
    outcome = table.run(select([key])[0], Laboratory(tmp_path, quick=True))
    assert not outcome.error
    assert outcome.claims
