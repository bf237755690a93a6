"""How the outcomes of attacks are counted, recorded and told."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.faults import __main__ as attacks
from tests.faults.fault import Case, Fault, Tally
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


def test_an_unknown_key_is_exit_2_with_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert attacks.main(["F99"]) == 2
    assert "F01" in capsys.readouterr().err


def test_the_readme_shows_what_is_recorded() -> None:
    readme, calls = README.read_text(), read(attacks.RECORD)
    assert any(table(calls[:n]) in readme for n in range(len(calls) + 1))  # attacks may have been made since
