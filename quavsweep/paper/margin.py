"""Past the paper: how far its three cases are from tumbling, by region, by basin, and by the angle in flight."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from quavsweep.margin import Margin, find_margin, write_margin
from quavsweep.margin.finding import Gain, Line, Side
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.run import Runs
from quavsweep.paper.thumbnail import MARGIN_POINTS
from quavsweep.plot.margin import make_margins_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CASES = (1, 2, 3)
BY = {"region": "margin_case", "basin": "margin_case", "angle": "margin_flight"}  # with what the configs are named


def analyse(runs: Runs) -> Findings:
    """Find the nine margins, each in folders of its own."""
    margins = [[_margin(runs, case, by) for by in BY] for case in CASES]
    tables = [
        Table(
            f"Case {case}, {found.by} (tumbling: {found.criterion}; here it "
            f"{'tumbles, and distances are those to safety' if found.base.answer.tumbles else 'does not'})",
            ("direction", "base", "distance", "%", "last run before it", "first run beyond it", "beyond"),
            [_row(found, line) for line in found.lines],
        )
        for case, row in zip(CASES, margins, strict=True)
        for found in row
    ]
    gains = [
        (f"Case {case}, {found.by}", *(_gain(gain) for gain in found.gains))
        for case, row in zip(CASES, margins, strict=True)
        for found in row
    ]
    names = [gain.name for gain in margins[0][0].gains]
    head = ("craft and criterion", *(f"{name} +1 %" for name in names))
    tables.append(Table("What a change of one parameter gains in the distance in Omega1 (rad/s)", head, gains))
    return Findings(data=margins, tables=tables, text=TEXT)


TEXT = (
    "A distance is that of the nearest change which a scan sees; two runs show it, at 0.99 and 1.01 of it. `<` marks a "
    "bound: the answer changes too near to the craft to tell where. `rough` marks gains whose two sides disagree, as "
    "they do at fractal borders. A craft falls 200 m in 18 s, so what counts in flight is the angle, not the region."
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


def _row(found: Margin, line: Line) -> tuple[str, ...]:
    """Return what was found along a direction, on the nearer side."""
    direction, unit, side = line.direction, found.unit(line), line.nearest
    base = f"{direction.base:.6g} {unit}"
    if side is None or side.distance is None:
        return (
            direction.name,
            base,
            f"> {line.reached:.3g}",
            f"> {100 * line.reached / direction.scale:.3g}",
            "",
            "",
            "",
        )
    sign = "-" if side.way.sign < 0 else "+"
    distance = f"{'< ' if side.bound else ''}{sign}{side.distance:.4g}"
    percent = f"{sign}{100 * side.distance / direction.scale:.3g}"
    return direction.name, base, distance, percent, *_bracket(line, side)


def _bracket(line: Line, side: Side) -> tuple[str, str, str]:
    """Return the two runs that show a distance, and what lies beyond it."""
    assert side.inner is not None
    assert side.outer is not None
    inner, outer = (probe.values[line.direction.along] for probe in (side.inner, side.outer))
    return f"{inner:.7g} ({side.inner.answer.what})", f"{outer:.7g}", side.outer.answer.what


def _gain(gain: Gain) -> str:
    if not gain.enters:
        return "0, does not enter"
    value = gain.per_percent
    return "not known" if math.isnan(value) else f"{value:+.3g}" + (" (rough)" if gain.rough else "")


FIGURE = Item(
    name="margin",
    title="How far the three cases are from tumbling: what scans along each parameter find, by three criteria",
    analyse=analyse,
    draw=draw,
)
