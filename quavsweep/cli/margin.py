"""The verb `margin`: how far a craft is from tumbling."""

from __future__ import annotations

import math
import textwrap
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from quavsweep.cli.option import PATH, changes_option, model_option
from quavsweep.cli.run import max_time_option, workers_option
from quavsweep.cli.stop import stop_on_signals
from quavsweep.cli.text import COLUMNS, count, duration, say, table, warn

if TYPE_CHECKING:
    from quavsweep.margin.finding import Gain, Line, Margin, Side

HEAD = ("direction", "base", "to", "change", "%", "safe at", "tumbles at")
WIDTHS = (14, 9, 9, 13, 7, 14, 14)  # 80 columns in all
LEFT = sum(WIDTHS[:3])  # of the columns that say which line it is


@click.command()
@click.argument("config", type=PATH)
@click.option(
    "--by",
    type=click.Choice(["region", "basin", "angle"]),
    default="region",
    show_default=True,
    help="What tumbling is: where one start ends, the share of starts that end elsewhere, or the roll angle.",
)
@click.option("--out", type=PATH, metavar="DIR", help="Folder of the runs; default results/<name>-margin/<by>.")
@click.option("--reach", type=float, default=50.0, show_default=True, metavar="PERCENT", help="How far to look.")
@click.option("--points", type=int, help="Points of a scan up to there, each way; default 100, by basin 50.")
@click.option("--share", type=float, default=5.0, show_default=True, metavar="PERCENT", help="Of starts, by basin.")
@click.option("--degrees", type=float, default=60.0, show_default=True, help="Of roll, by angle.")
@click.option("--within", type=float, default=20.0, show_default=True, metavar="T", help="Time for that, by angle.")
@changes_option
@model_option
@workers_option
@max_time_option
@click.option("--no-plot", is_flag=True, help="Do not draw margin.png at the end.")
def margin(
    config: Path,
    by: str,
    out: Path | None,
    reach: float,
    points: int | None,
    share: float,
    degrees: float,
    within: float,
    changes: tuple[str, ...],
    model: Path | None,
    workers: int,
    max_time: float | None,
    no_plot: bool,
) -> None:
    """Say how far the craft of a CONFIG file is from the nearest point where it tumbles.

    \b
    quavsweep margin configs/omega_c.yaml
    quavsweep margin configs/paper/margin_case_1.yaml --by basin
    quavsweep margin configs/paper/margin_flight_1.yaml --by angle

    Two runs show each distance, at 0.99 and 1.01 of it. Ctrl-C stops it (exit 75); the same command continues it.
    """
    begin = time.monotonic()
    stop = stop_on_signals(max_time)
    from quavsweep.cli.progress import show_progress
    from quavsweep.config import load_sweep
    from quavsweep.margin import find_margin, write_margin

    sweep = load_sweep(config, changes, model)
    with show_progress(f"{sweep.name} by {by}") as shown:
        found = find_margin(
            sweep,
            by,
            out=out,
            reach=reach / 100,
            points=points,
            share=share / 100,
            degrees=degrees,
            within=within,
            workers=workers,
            observe=shown,
            stop=stop,
        )
    for note in found.notes:
        warn(f"note: {config}: {note}")
    rows = [("written", str(write_margin(found)))]
    if not no_plot:
        from quavsweep.plot.margin import draw_margin

        rows.append(("figure", str(draw_margin(found, found.folder / "margin.png"))))
    cells = sum(points_of for _, points_of in found.runs)
    spent = f"{duration(time.monotonic() - begin)}, {count(cells, 'point')} in {count(len(found.runs), 'run')}"
    say(
        "\n".join(
            [table(_craft(found)), "", *_distances(found), "", *_gains(found), "", table([*rows, ("time", spent)])]
        )
    )


def _craft(found: Margin) -> list[tuple[str, str]]:
    """Return what was asked, as rows."""
    from quavsweep.margin.word import state_words

    model = found.sweep.model
    craft = {line.direction.along: line.direction.base for line in found.lines}
    values = [f"{name} = {value:.6g} {model.quantity(name).unit}".removesuffix(" 1") for name, value in craft.items()]
    spacing = max(s.way.spacing / line.direction.scale for line in found.lines for s in line.sides)
    seen = f"the nearest change that a scan in steps of {100 * spacing:.3g} % sees, up to {100 * found.reach:g} %"
    return [
        ("craft", f"{found.sweep.name}: {model.name}, {', '.join(values)}"),
        ("tumbling", found.criterion),
        ("here", f"the craft {state_words(found.leading)}"),
        ("change", f"of the parameter, with its sign, to {seen}: to safety where the base tumbles, else to tumbling"),
        ("marks", "* the nearer way; < a bound, where even runs side by side differ"),
    ]


def _aligned(cells: tuple[str, ...]) -> str:
    first, *others = (
        f"{cell:<{w}}" if i == 0 else f" {cell:>{w - 1}}"
        for i, (cell, w) in enumerate(zip(cells, WIDTHS, strict=False))
    )
    return "".join([first, *others]).rstrip()


def _distances(found: Margin) -> list[str]:
    """Return a table of the directions, both ways, with what the two runs of each change found below them."""
    lines = [_aligned(HEAD)]
    for line in found.lines:
        unit = found.unit(line)
        name = line.direction.name + ("" if unit == "1" else f" {unit}")
        for side in line.sides:
            lines += _rows((name, f"{line.direction.base:.5g}") if side is line.sides[0] else ("", ""), line, side)
    return lines + [f"{name:<{WIDTHS[0]}}{'does not enter':>{WIDTHS[1] + WIDTHS[2]}}" for name in found.absent]


def _rows(name: tuple[str, str], line: Line, side: Side) -> list[str]:
    """Return the lines of one way."""
    from quavsweep.margin.word import answer_words, bound_words, end_words, value_words

    if side.change is None or side.inner is None or side.outer is None:
        first, *more = textwrap.wrap(end_words(side), COLUMNS - LEFT - 2)
        return [_aligned((*name, line.to)) + f"  {first}", *(" " * (LEFT + 2) + text for text in more)]
    probes = sorted((side.inner, side.outer), key=lambda probe: probe.answer.tumbles)
    values = value_words(line, side, WIDTHS[-1] - 1)
    found = [answer_words(probe.answer, brief=True) for probe in probes]
    mark = "< " if side.bound else "* " if side is line.nearest else ""
    relative = _percent(side.change / line.direction.scale)
    rows = [_aligned((*name, line.to, f"{mark}{side.change:+.4g}", relative, *values))]
    rows.append(_aligned(("", "", "", "", "", *found)))
    return rows + [f"  {text}" for text in textwrap.wrap(bound_words(side), COLUMNS - 2)]


def _percent(share: float) -> str:
    digits = ".3g" if abs(share) >= 0.1 else ".2g" if abs(share) >= 1e-3 else ".0e"
    return f"{100 * share:+{digits}}"


def _gains(found: Margin) -> list[str]:
    """Return a table of what 1 % more of each parameter gains in the leading direction."""
    leading, unit = found.leading.direction.name, found.unit(found.leading)
    per = f"{leading}" + ("" if unit == "1" else f" [{unit}]")
    head = f"{'gain in ' + per + ' by 1 % more of':<44}{'gain':>12}{'from -1 %':>12}{'from +1 %':>12}"
    note = "a gain above 0 is safer: farther from tumbling, or nearer to safety"
    return [head, *(text for gain in found.gains for text in _gain(gain, unit)), f"  ({note})"]


def _gain(gain: Gain, unit: str) -> list[str]:
    from quavsweep.margin.word import unknown_words

    if not gain.enters:
        return [f"{'  ' + gain.name:<44}{'0':>12}  does not enter"]
    numbers = gain.per_percent, gain.from_below, gain.from_above
    if not any(map(math.isfinite, numbers)):
        return [f"  {gain.name:<6}{unknown_words(gain, unit)}"]
    why = "  rough: the sides disagree" if gain.rough else ""
    lines = [f"{'  ' + gain.name + why:<44}" + "".join(f"{_number(x):>12}" for x in numbers)]
    return lines + ([f"        {text}"] if (text := unknown_words(gain, unit)) else [])


def _number(value: float) -> str:
    return f"{value:+.4g}" if math.isfinite(value) else "unknown"
