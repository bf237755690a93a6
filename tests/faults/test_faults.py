"""How the outcomes of attacks are counted, recorded and told."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.faults import __main__ as attacks
from tests.faults.arena import Arena
from tests.faults.fault import Case, Fault, NotRunError, Tally
from tests.faults.push import hold
from tests.faults.record import add, read, table, told

README = Path(__file__).parents[2] / "README.md"


def _fault(*cases: Case) -> Fault:
    return Fault("F01", "a fault", len(cases), len(cases), lambda arena, n: iter(cases))


@pytest.mark.parametrize(
    ("case", "holds"),
    [(Case(True), True), (Case(False, "lost"), False), (Case(True, "other bytes", silent=True), False)],
)
def test_a_fault_holds_if_every_case_survived_and_none_was_silent(case: Case, holds: bool) -> None:
    tally = Tally(_fault(case)).count([Case(True), case])
    assert tally.holds is holds
    assert (f"WRONG: {case.note}" in told(tally)) is bool(case.note)


def test_nothing_run_is_nothing_held() -> None:
    assert not Tally(_fault()).count([]).holds


def test_the_record_accumulates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(attacks, "select", lambda keys: [_fault(Case(True, kinds=("soft",)), Case(True))])
    file = tmp_path / "faults.json"
    assert [attacks.main(["--json", str(file)]) for _ in range(2)] == [0, 0]
    assert [call["faults"]["F01"]["survived"] for call in read(file)] == [2, 2]
    assert "| 4 | 4 | 0 | 0 |" in table(read(file))


def test_the_table_counts_cases_since_a_fault_last_got_through(tmp_path: Path) -> None:
    file = tmp_path / "faults.json"
    for case in (Case(False, "lost"), Case(True), Case(True)):
        add(file, [Tally(_fault(case)).count([case])], seed=0)
    assert "| 2 | 2 | 0 | 1 |" in table(read(file))
    add(file, [Tally(_fault()).count([Case(False, "lost")])], seed=0)
    assert "| 4 | 2 | 0 | 0 |" in table(read(file))


def test_the_table_tells_changes_parts_and_no_push(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "faults.json"

    def partly(arena: Arena, cases: int) -> Iterator[Case]:
        yield Case(True)
        raise NotRunError("no disk to mount")

    monkeypatch.setattr("tests.faults.record.commit", lambda: {"id": "0123456789", "dirty": True})
    add(file, [Tally(_fault()).count([Case(True)])], seed=0, push=True)
    assert "| 0 | 0 | 0 | 0 | not run |" in table(read(file))
    add(file, [Tally(_fault()).count(partly(None, 2))], seed=0)  # type: ignore[arg-type]
    [row] = [line for line in table(read(file)).splitlines() if line.startswith("| F01")]
    assert "| 1 | 1 | 0 | 0 | " in row
    assert row.endswith("(in part) | 0123456+ |")


@pytest.mark.parametrize("survived", [True, False])
def test_what_got_through_is_not_skipped(survived: bool, tmp_path: Path) -> None:
    def attack(arena: Arena, cases: int) -> Iterator[Case]:
        yield Case(survived)
        raise NotRunError("no disk to mount")

    expected = pytest.raises(pytest.skip.Exception if survived else AssertionError)
    with expected:
        hold(Fault("F01", "a fault", 2, 2, attack), tmp_path)


def test_an_unknown_key_is_exit_2_with_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert attacks.main(["F99"]) == 2
    assert "F01" in capsys.readouterr().err


def test_the_readme_shows_what_is_recorded() -> None:
    readme, calls = README.read_text(), read(attacks.RECORD)
    shown = max(n for n in range(len(calls) + 1) if table(calls[:n]) in readme)
    since = [told for call in calls[shown:] for told in call["faults"].values()]  # attacks may have been made since
    assert all(told["survived"] == told["cases"] and not told["whole"] for told in since)
