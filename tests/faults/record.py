"""The outcomes: as text, and as JSON that accumulates call by call with date and commit."""

from __future__ import annotations

import json
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmarks.machine import commit
from quavsweep.provenance import machine
from tests.faults.catalogue import FAULTS
from tests.faults.fault import Tally

HEAD = f"{'':5} {'fault':58} {'cases':>7} {'survived':>9} {'silent':>7}"


def told(tally: Tally) -> str:
    """Return a row of the table: fault, cases, survived, silent errors; below it what went wrong."""
    lines = [_row(tally.fault.key, tally.fault.title, tally.cases, tally.survived, tally.silent)]
    if tally.kinds:
        lines.append(f"      {', '.join(f'{kind} {n:,}' for kind, n in sorted(tally.kinds.items()))}")
    if tally.not_run:
        lines.append(f"      NOT RUN: {tally.not_run}")
    lines += [f"      WRONG: {text}" for text in (*([tally.whole] if tally.whole else []), *tally.failures[:10])]
    return "\n".join(lines)


def _row(key: str, title: str, cases: int, survived: int, silent: int) -> str:
    return f"{key:5} {title:58} {cases:>7,} {survived:>9,} {silent:>7,}"


def add(file: Path, tallies: Sequence[Tally], seed: int, push: bool = False) -> None:
    """Add what was measured to a file of all that was measured before; of a push, the table does not tell."""
    calls = read(file)
    calls.append(
        {
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "commit": commit(),
            "machine": machine(),
            "seed": seed,
            "push": push,
            "faults": {tally.fault.key: _plain(tally) for tally in tallies},
        }
    )
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(calls, indent=1) + "\n")


def read(file: Path) -> list[dict[str, Any]]:
    """Return the calls that a file records, none if there is no file."""
    return json.loads(file.read_text()) if file.exists() else []


def _plain(tally: Tally) -> dict[str, Any]:
    return {
        "cases": tally.cases,
        "survived": tally.survived,
        "silent": tally.silent,
        "kinds": dict(tally.kinds),
        "failures": tally.failures,
        "whole": tally.whole,
        "not_run": tally.not_run,
        "seconds": round(tally.seconds, 1),
    }


def _short(commit: dict[str, Any]) -> str:
    return f"{str(commit['id'])[:7]}{'+' if commit['dirty'] else ''}"


def table(calls: Sequence[dict[str, Any]]) -> str:
    """Return the table of what calls found.

    Commits with a + had changes that were not committed. Cases count since a fault last got through; what got through
    before, and was mended, has a column of its own.
    """
    lines = ["| fault | cases | survived | silent | mended before | date | commits |", "|---|---|---|---|---|---|---|"]
    for fault in FAULTS:
        asked = [call for call in calls if fault.key in call["faults"] and not call.get("push")]
        found = [(call, told) for call in asked if (told := call["faults"][fault.key])["cases"]]
        bad = [number for number, (_, told) in enumerate(found) if told["survived"] < told["cases"] or told["whole"]]
        first = bad[-1] + 1 if bad and bad[-1] + 1 < len(found) else 0
        since = found[first:]
        sums = {key: sum(told[key] for _, told in since) for key in ("cases", "survived", "silent")}
        mended = sum(told["cases"] - told["survived"] for _, told in found[:first])
        when = max((call["date"][:10] for call, _ in since), default="not run")
        when += " (in part)" * any(told["not_run"] for _, told in since)
        commits = ", ".join(dict.fromkeys(_short(call["commit"]) for call, _ in since))
        numbers = " | ".join(f"{n:,}" for n in (*sums.values(), mended))
        lines.append(f"| {fault.key} {fault.title} | {numbers} | {when} | {commits} |")
    return "\n".join(lines)
