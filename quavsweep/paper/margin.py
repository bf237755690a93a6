"""Past the paper: how far its three cases are from tumbling, by region, by basin, and by the angle in flight."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from quavsweep.margin import Margin, find_margin, write_margin
from quavsweep.margin.criterion import WITHIN
from quavsweep.margin.finding import Gain, Line, Side
from quavsweep.margin.word import answer_words, bound_words, span_words, state_words, unknown_words, value_words
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.run import Runs
from quavsweep.paper.thumbnail import MARGIN_POINTS
from quavsweep.plot.margin import make_margins_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CASES = (1, 2, 3)
BY = {"region": "margin_case", "basin": "margin_case", "angle": "margin_flight"}  # with what the configs are named
HEAD = ("direction", "base", "distance to", "change", "%", "safe run", "tumbling run")
DIGITS = 14  # characters of a value
ID = 12  # digits of a result id that a table shows


def analyse(runs: Runs) -> Findings:
    """Find the nine margins, each in folders of its own."""
    margins = [[_margin(runs, case, by) for by in BY] for case in CASES]
    named = [(f"Case {case}, {found.by}", found) for case, row in zip(CASES, margins, strict=True) for found in row]
    tables = [
        Table(
            f"{name} (tumbling: {found.criterion}; the craft itself {state_words(found.leading)})",
            HEAD,
            [_row(found, line) for line in found.lines],
        )
        for name, found in named
    ]
    names = [gain.name for gain in margins[0][0].gains]
    head = ("craft and criterion", *(f"{name} +1 %" for name in names))
    gains = [(name, *(_gain(gain, found.unit(found.leading)) for gain in found.gains)) for name, found in named]
    tables.append(Table("What a change of one parameter gains in the margin in Omega1 (rad/s)", head, gains))
    ids = [(name, ", ".join(f"`{result_id[:ID]}`" for result_id, _ in found.runs)) for name, found in named]
    tables.append(Table("The runs, in order", ("craft and criterion", "results"), ids))
    text = " ".join((TEXT, _late([found for row in margins for found in row])))
    return Findings(data=margins, tables=tables, text=text, sources=_sources(runs, margins))


TEXT = (
    "A distance is that of the nearest change which a scan sees, on the nearer side; two runs show it, at 0.99 and "
    "1.01 of it. It is one to tumbling, or, where the craft tumbles at the base of that row, one to safety; the sign "
    "is that of the change of the parameter. `<` marks a bound. A gain above 0 is one in safety: farther from "
    "tumbling, or nearer to safety; `rough` marks gains whose two sides disagree, as they do at fractal borders. "
    "Where Omega1 has no change within reach, gains follow it farther, coarsely. In flight a craft reaches the ground "
    "before its region shows (Figure 12), so what counts there is the angle."
)


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw what the scans found, a row for each case and a column for each criterion."""
    return make_margins_figure(findings.data, [f"Case {case}" for case in CASES], [f"by {by}" for by in BY])


def _margin(runs: Runs, case: int, by: str) -> Margin:
    sweep = runs.sweep(f"{BY[by]}_{case}")
    points = MARGIN_POINTS if runs.changes else None
    folder = runs.out / "margin" / f"case_{case}" / by
    with runs.show(f"{sweep.name} by {by}") as observe:
        found = find_margin(sweep, by, out=folder, points=points, workers=runs.workers, observe=observe, stop=runs.stop)
    write_margin(found)
    return found


def _sources(runs: Runs, margins: Sequence[Sequence[Margin]]) -> dict[str, dict[str, str]]:
    """Return the result ids of all runs by their folders, by config."""
    sources: dict[str, dict[str, str]] = {}
    for found in (found for row in margins for found in row):
        folder = found.folder.relative_to(runs.out)
        ids = {f"{folder}/probe-{n}": result_id for n, (result_id, _) in enumerate(found.runs, 1)}
        sources.setdefault(found.sweep.name, {}).update(ids)
    return sources


def _row(found: Margin, line: Line) -> tuple[str, ...]:
    """Return what was found along a direction, on the nearer side."""
    direction, unit, side = line.direction, found.unit(line), line.nearest
    base = f"{direction.base:.6g} {unit}"
    if direction.follow is not None:  # a base of its own
        base += f", where the craft {state_words(line)}"
    if side is None or side.change is None:
        return direction.name, base, line.to, span_words(line, unit), "", "", ""
    change = f"{'< ' if side.bound else ''}{side.change:+.4g}"
    percent = f"{100 * side.change / direction.scale:+.3g}"
    return direction.name, base, line.to, change, percent, *_bracket(line, side)


def _bracket(line: Line, side: Side) -> tuple[str, str]:
    """Return the safe run and the tumbling one that show a distance, with what each found."""
    assert side.inner is not None
    assert side.outer is not None
    probes = sorted((side.inner, side.outer), key=lambda probe: probe.answer.tumbles)
    values = value_words(line, side, DIGITS)
    safe, tumbling = (f"{v} ({answer_words(probe.answer)})" for v, probe in zip(values, probes, strict=True))
    return safe, tumbling + (f"; {bound_words(side)}" if side.bound else "")


def _gain(gain: Gain, unit: str) -> str:
    if not gain.enters:
        return "0, does not enter"
    value = gain.per_percent
    return unknown_words(gain, unit) if math.isnan(value) else f"{value:+.3g}" + (" (rough)" if gain.rough else "")


def _late(margins: Sequence[Margin]) -> str:
    """Say how many limits by angle lie at the end of the time: their safe runs have the largest angle there."""
    times = [time for found in margins if found.by == "angle" for time in _safe_peaks(found)]
    if not times:
        return ""
    late = sum(time > 0.98 * WITHIN for time in times)
    return (
        f"{late} of {len(times)} changes by angle have the largest angle of their safe run in the last 2 % of the "
        f"{WITHIN:g} s: it still grows there, and such a limit is one of that time, not of the craft."
    )


def _safe_peaks(found: Margin) -> Iterator[float]:
    """Yield the times of the largest angle in the safe run of each change."""
    for line in found.lines:
        for side in line.sides:
            safe = side.outer if line.base.answer.tumbles else side.inner
            if safe is not None:
                yield safe.answer.numbers["peak_time"]


FIGURE = Item(
    name="margin",
    title="How far the three cases are from tumbling: what scans along each parameter find, by three criteria",
    analyse=analyse,
    draw=draw,
)
