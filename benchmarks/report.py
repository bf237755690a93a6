"""The outcomes as a table of at most 80 columns, and as JSON with every sample."""

from __future__ import annotations

import statistics
import textwrap
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from benchmarks.machine import describe
from benchmarks.protocol import Protocol
from benchmarks.row import Outcome, Row

WIDTH = 80


def table(outcomes: Sequence[Outcome], protocol: Protocol) -> str:
    """Return the table: row, median (least .. greatest), target, verdict, and below each what to know of it."""
    lines = [_line("row", "median (min..max)", "target", "verdict"), "-" * WIDTH]
    for outcome in outcomes:
        row, measurement = outcome.row, outcome.measurement
        figure = "-"
        if measurement is not None:
            low, high = min(measurement.values), max(measurement.values)
            spread = f" ({low:.3g}..{high:.3g})" if high > low else ""
            figure = f"{measurement.value:.4g}{spread} {row.unit}".rstrip()
        lines.append(_line(row.title, figure, target(row), outcome.verdict))
        note = outcome.reason or (measurement.note if measurement else "")
        for line in note.split("\n"):
            lines += textwrap.wrap(line, WIDTH, initial_indent="    ", subsequent_indent="    ")
    kind = "QUICK (thumbnails of sweeps): " if protocol.quick else "at least "
    lines += ["-" * WIDTH, f"{kind}{protocol.samples} interleaved samples of {protocol.seconds:g} s a side"]
    return "\n".join(lines)


def _line(row: str, figure: str, bound: str, verdict: str) -> str:
    return f"{row:30} {figure:28} {bound:>10}  {verdict}".rstrip()


def target(row: Row) -> str:
    """Return a row's target in words."""
    if row.target is None:
        return "state it"
    return f"{'>=' if row.target.at_least else '<='} {row.target.bound:g} {row.unit}".rstrip()


def record(outcomes: Sequence[Outcome], protocol: Protocol) -> dict[str, Any]:
    """Return everything as data: machine, versions, commit, protocol, and every sample of every row."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": describe(),
        "quick": protocol.quick,
        "protocol": {"samples": protocol.samples, "least_seconds": protocol.seconds},
        "rows": [_row(outcome) for outcome in outcomes],
    }


def _row(outcome: Outcome) -> dict[str, Any]:
    row, measurement = outcome.row, outcome.measurement
    data: dict[str, Any] = {"key": row.key, "suite": row.suite, "title": row.title, "unit": row.unit}
    data |= {"target": target(row), "verdict": outcome.verdict, "reason": outcome.reason}
    if measurement is not None:
        data |= {
            "median": measurement.value,
            "min": min(measurement.values),
            "max": max(measurement.values),
            "values": measurement.values,
            "samples": measurement.samples,
            "sample_medians": {name: statistics.median(x) for name, x in measurement.samples.items()},
            "sample_unit": measurement.sample_unit,
            "note": measurement.note,
            "detail": dict(measurement.detail),
        }
    return data
