"""The report: every number of the paper beside the computed one, the figures, and what failed."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from quavsweep.paper.item import Table
from quavsweep.paper.outcome import Outcome, heading
from quavsweep.paper.row import ERRORS, Row, Verdict
from quavsweep.store import publish_bytes

HEAD = ("what", "where", "paper", "computed", "error", "verdict", "reason")


def write_report(out: Path, outcomes: Sequence[Outcome], quick: bool) -> None:
    """Write `report.md` and `report.json` into a folder.

    Raises
    ------
    DiskError
        If the disk refuses.
    """
    publish_bytes(out / "report.md", ("\n".join(_lines(outcomes, quick)) + "\n").encode())
    data = {"quick": quick, "items": [_data(outcome) for outcome in outcomes]}
    publish_bytes(out / "report.json", json.dumps(data, indent=1, ensure_ascii=False).encode() + b"\n")


def counts(outcomes: Sequence[Outcome]) -> dict[Verdict, int]:
    """Return how many rows have each verdict, in the order of the verdicts."""
    found = Counter(row.verdict for outcome in outcomes for row in outcome.rows)
    return {verdict: found[verdict] for verdict in Verdict}


def _lines(outcomes: Sequence[Outcome], quick: bool) -> Iterator[str]:
    """Yield the lines of the report."""
    yield "# The paper, computed again"
    yield ""
    if quick:
        yield "**Thumbnails: the grids are cut, so most numbers here mean nothing.**"
        yield ""
    verdicts = counts(outcomes)
    total = sum(verdicts.values())
    yield f"{total} numbers and statements: " + ", ".join(f"{n} {verdict}" for verdict, n in verdicts.items()) + "."
    yield ""
    yield (
        f"A number agrees if it is within half a unit of the last printed digit; within the error, if {ERRORS:g} "
        "errors more make it so. The verdict follows from the printed digits, the computed value and its error; only "
        "the reason is written by hand."
    )
    yield ""
    yield from _table(Table("", ("item", *Verdict), [_summary(outcome) for outcome in outcomes]))
    for outcome in outcomes:
        yield from _section(outcome)


def _summary(outcome: Outcome) -> tuple[str, ...]:
    name = f"[{outcome.item.name}](#{outcome.item.name})" + (" **failed**" if outcome.error else "")
    return name, *(str(n) if n else "" for n in counts([outcome]).values())


def _section(outcome: Outcome) -> Iterator[str]:
    """Yield what the report says of an item."""
    item = outcome.item
    yield f'## <a id="{item.name}"></a>{heading(item.name)}'
    yield ""
    if outcome.error:
        yield f"**Failed: {outcome.error}** (`failed/{item.name}.txt`)"
        yield ""
    elif outcome.figure is not None:
        yield f"![{item.title}]({outcome.figure})"
        yield ""
    yield f"*{item.title}. {outcome.source}.*"
    yield ""
    if outcome.findings.text:
        yield outcome.findings.text
        yield ""
    if outcome.rows:
        yield from _table(Table("", HEAD, [_texts(row) for row in outcome.rows]))
    for table in outcome.findings.tables:
        yield f"{table.title}:"
        yield ""
        yield from _table(table)


def _table(table: Table) -> Iterator[str]:
    """Yield a table in Markdown."""
    yield _line(table.head)
    yield _line("---" for _ in table.head)
    yield from (_line(row) for row in table.rows)
    yield ""


def _line(cells: Any) -> str:
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def _texts(row: Row) -> tuple[str, ...]:
    """Return a row of the report."""
    printed, computed = row.printed, row.computed
    unit = f" {printed.unit}" if printed.unit else ""
    shown = row.shown + unit if computed else ""
    error = "" if computed is None or not computed.error else f"{computed.error:.2g}"
    note = computed.note if computed else ""
    said = "; ".join(text for text in (note, row.reason) if text)
    return printed.what, printed.where, printed.paper + unit, shown, error, row.verdict, said


def _data(outcome: Outcome) -> dict[str, Any]:
    """Return an item as JSON."""
    return {
        "item": outcome.item.name,
        "title": outcome.item.title,
        "figure": str(outcome.figure) if outcome.figure else None,
        "results": outcome.all_result_ids,
        "error": outcome.error,
        "text": outcome.findings.text,
        "rows": [_row_data(row) for row in outcome.rows],
        "tables": [
            {"title": table.title, "head": list(table.head), "rows": [list(row) for row in table.rows]}
            for table in outcome.findings.tables
        ],
    }


def _row_data(row: Row) -> dict[str, Any]:
    printed, computed = row.printed, row.computed
    return {
        "key": printed.key,
        "where": printed.where,
        "what": printed.what,
        "unit": printed.unit,
        "paper": printed.paper,
        "computed": None if computed is None else computed.value,
        "error": None if computed is None else computed.error,
        "note": "" if computed is None else computed.note,
        "verdict": str(row.verdict),
        "reason": row.reason,
    }
