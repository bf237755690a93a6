"""The report: every number of the paper beside the computed one, the figures, and what failed."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from quavsweep.paper.item import Table
from quavsweep.paper.outcome import Outcome, heading
from quavsweep.paper.row import ERRORS, Row, Verdict
from quavsweep.whole import publish_bytes

HEAD = ("what", "where", "paper", "computed", "error", "verdict", "reason")
FIELDS = {"item", "title", "figure", "source", "results", "error", "text", "rows", "tables"}
ROW_FIELDS = {"key", "where", "what", "unit", "paper", "computed", "shown", "error", "note", "verdict", "reason"}
Entry = Mapping[str, Any]  # an item as it stands in report.json


def write_report(out: Path, outcomes: Sequence[Outcome], order: Sequence[str], quick: bool) -> list[Entry]:
    """Write `report.md` and `report.json` into a folder; items done earlier, by an earlier call, stay in them.

    Parameters
    ----------
    out : Path
    outcomes : sequence of Outcome
        The items that were done now.
    order : sequence of str
        The names of all items, in the order of the report.
    quick : bool

    Returns
    -------
    list of mappings
        All items of the report.

    Raises
    ------
    DiskError
        If the disk refuses.
    """
    known = {entry["item"]: entry for entry in [*_earlier(out), *map(_data, outcomes)]}
    entries = [known[name] for name in order if name in known]
    publish_bytes(out / "report.md", ("\n".join(_lines(entries, quick)) + "\n").encode())
    data = {"quick": quick, "items": entries}
    publish_bytes(out / "report.json", json.dumps(data, indent=1, ensure_ascii=False).encode() + b"\n")
    return entries


def _earlier(out: Path) -> list[Entry]:
    """Return the items of the report that is there, as far as they can be read."""
    try:
        items = json.loads((out / "report.json").read_text("utf-8"))["items"]
        fit = [item for item in items if set(item) == FIELDS]
        return [item for item in fit if all(set(row) == ROW_FIELDS for row in item["rows"])]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def counts(entries: Sequence[Entry]) -> dict[Verdict, int]:
    """Return how many rows have each verdict, in the order of the verdicts."""
    found = Counter(row["verdict"] for entry in entries for row in entry["rows"])
    return {verdict: found[str(verdict)] for verdict in Verdict}


def _lines(entries: Sequence[Entry], quick: bool) -> Iterator[str]:
    """Yield the lines of the report."""
    yield "# The paper, computed again"
    yield ""
    if quick:
        yield "**Thumbnails: the grids are cut, so most numbers here mean nothing.**"
        yield ""
    verdicts = counts(entries)
    total = sum(verdicts.values())
    yield f"{total} numbers and statements: " + ", ".join(f"{n} {verdict}" for verdict, n in verdicts.items()) + "."
    yield ""
    yield (
        f"A number agrees if it is within half a unit of the last printed digit; within the error, if {ERRORS:g} "
        "errors more make it so. The verdict follows from the printed digits, the computed value and its error; only "
        "the reason is written by hand."
    )
    yield ""
    yield from _table(("item", *Verdict), [_summary(entry) for entry in entries])
    for entry in entries:
        yield from _section(entry)


def _summary(entry: Entry) -> tuple[str, ...]:
    name = f"[{heading(entry['item'])}](#{entry['item']})" + (" **failed**" if entry["error"] else "")
    return name, *(str(n) if n else "" for n in counts([entry]).values())


def _section(entry: Entry) -> Iterator[str]:
    """Yield what the report says of an item."""
    name, title = entry["item"], entry["title"]
    yield f'## <a id="{name}"></a>{heading(name)}'
    yield ""
    if entry["error"]:
        yield f"**Failed: {entry['error']}** (`failed/{name}.txt`)"
        yield ""
    elif entry["figure"]:
        yield f"![{title}]({entry['figure']})"
        yield ""
    yield f"*{title}. {entry['source']}.*"
    yield ""
    if entry["text"]:
        yield entry["text"]
        yield ""
    if entry["rows"]:
        yield from _table(HEAD, [_texts(row) for row in entry["rows"]])
    for table in entry["tables"]:
        yield f"{table['title']}:"
        yield ""
        yield from _table(table["head"], table["rows"])


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield a table in Markdown."""
    yield _line(head)
    yield _line(["---"] * len(head))
    yield from map(_line, rows)
    yield ""


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def _texts(row: Entry) -> tuple[str, ...]:
    """Return a row of the report."""
    unit = f" {row['unit']}" if row["unit"] else ""
    shown = row["shown"] + unit if row["shown"] else ""
    error = f"{row['error']:.2g}" if row["error"] else ""
    said = "; ".join(text for text in (row["note"], row["reason"]) if text)
    return row["what"], row["where"], row["paper"] + unit, shown, error, row["verdict"], said


def _data(outcome: Outcome) -> Entry:
    """Return an item as JSON."""
    return {
        "item": outcome.item.name,
        "title": outcome.item.title,
        "figure": str(outcome.figure) if outcome.figure else None,
        "source": outcome.source,
        "results": outcome.all_result_ids,
        "error": outcome.error,
        "text": outcome.findings.text,
        "rows": [_row_data(row) for row in outcome.rows],
        "tables": [_table_data(table) for table in outcome.findings.tables],
    }


def _table_data(table: Table) -> Entry:
    return {"title": table.title, "head": list(table.head), "rows": [list(row) for row in table.rows]}


def _row_data(row: Row) -> Entry:
    printed, computed = row.printed, row.computed
    return {
        "key": printed.key,
        "where": printed.where,
        "what": printed.what,
        "unit": printed.unit,
        "paper": printed.paper,
        "computed": None if computed is None else computed.value,
        "shown": row.shown,
        "error": None if computed is None else computed.error,
        "note": "" if computed is None else computed.note,
        "verdict": str(row.verdict),
        "reason": row.reason,
    }
