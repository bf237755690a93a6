"""The verb `margin`: how far a craft is from tumbling."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from quavsweep.cli.option import PATH, changes_option, model_option
from quavsweep.cli.run import max_time_option, stop_on_signals, workers_option
from quavsweep.cli.text import count, duration, say, table, warn

if TYPE_CHECKING:
    from quavsweep.margin.criterion import Answer
    from quavsweep.margin.finding import Line, Margin, Side

HEAD = ("direction", "base", "distance", "%", "safe at", "tumbles at", "beyond")
WIDTHS = (14, 9, 12, 7, 12, 12, 14)  # 80 columns in all


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
    model, base = found.sweep.model, found.base.answer
    craft = {line.direction.along: line.direction.base for line in found.lines}
    values = [f"{name} = {value:.6g} {model.quantity(name).unit}".removesuffix(" 1") for name, value in craft.items()]
    state = "tumbles: the distance is that to safety, less than 0" if base.tumbles else "does not tumble"
    numbers = "".join(f", {name.replace('_', ' ')} {value:.4g}" for name, value in base.numbers.items())
    spacing = max(s.way.spacing / line.direction.scale for line in found.lines for s in line.sides)
    seen = f"the nearest change that a scan in steps of {100 * spacing:.3g} % sees, up to {100 * found.reach:g} %"
    return [
        ("craft", f"{found.sweep.name}: {model.name}, {', '.join(values)}"),
        ("tumbling", found.criterion),
        ("here", f"it {state} ({base.what}{numbers})"),
        ("distances", f"{seen}; < where it lies too near to tell; * marks the nearer side"),
    ]


def _aligned(cells: tuple[str, ...]) -> str:
    first, *others = (
        f"{cell:<{w}}" if i == 0 else f"{cell:>{w}}" for i, (cell, w) in enumerate(zip(cells, WIDTHS, strict=True))
    )
    return "".join([first, *others]).rstrip()


def _distances(found: Margin) -> list[str]:
    """Return a table of the directions, both ways."""
    rows: list[tuple[str, ...]] = [HEAD]
    for line in found.lines:
        unit = found.unit(line)
        name = line.direction.name + ("" if unit == "1" else f" {unit}")
        for side in line.sides:
            rows.append(_row(name if side is line.sides[0] else "", line, side))
    rows += [(name, "-", "0", "0", "does not", "enter", "") for name in found.absent]
    return [_aligned(row) for row in rows]


def _row(name: str, line: Line, side: Side) -> tuple[str, ...]:
    direction = line.direction
    base = f"{direction.base:.5g}" if name else ""
    if side.distance is None or side.inner is None or side.outer is None:
        limit, why = side.way.limit, side.way.ended_by or "reach"
        return name, base, f"> {limit:.4g}", _percent(side.way.sign * limit / direction.scale), "", why[:12], ""
    mark = "<" if side.bound else "*" if side is line.nearest else ""
    values = _apart(*(probe.values[direction.along] for probe in (side.inner, side.outer)))
    safe, tumbles = values[::-1] if line.base.answer.tumbles else values
    relative = _percent(side.way.sign * side.distance / direction.scale)
    return name, base, f"{mark} {side.distance:.4g}".strip(), relative, safe, tumbles, _beyond(side.outer.answer)


def _percent(share: float) -> str:
    digits = ".3g" if abs(share) >= 0.1 else ".2g" if abs(share) >= 1e-3 else ".0e"
    return f"{100 * share:+{digits}}"


def _apart(one: float, other: float) -> tuple[str, str]:
    """Return two numbers with so many digits that they differ, as far as a column takes."""
    for digits in range(6, 17):
        texts = f"{one:.{digits}g}", f"{other:.{digits}g}"
        if texts[0] != texts[1] or max(map(len, texts)) >= WIDTHS[4] - 1:
            break
    return texts


def _beyond(answer: Answer) -> str:
    """Return what happens at the far run: its share with the binomial error, its angle, or its region."""
    numbers = answer.numbers
    if "share" in numbers:
        return f"{100 * numbers['share']:.1f} +- {100 * numbers['share_se']:.1f} %"
    if "peak_degrees" in numbers:
        return f"{numbers['peak_degrees']:.1f} deg"
    return answer.what.replace("quasi_periodic", "torus")


def _gains(found: Margin) -> list[str]:
    """Return a table of what 1 % more of each parameter gains in the leading direction."""
    leading, unit = found.leading.direction.name, found.unit(found.leading)
    per = f"gain in {leading}" + ("" if unit == "1" else f" [{unit}]")
    lines = [f"{per + ' by 1 % more of':<44}{'gain':>12}{'from -1 %':>12}{'from +1 %':>12}"]
    for gain in found.gains:
        if not gain.enters:
            lines.append(f"{'  ' + gain.name:<44}{'0':>12}  does not enter")
            continue
        numbers = (gain.per_percent, gain.from_below, gain.from_above)
        told = "".join(f"{_number(x):>{w}}" for x, w in zip(numbers, (12, 12, 12), strict=True))
        why = "  rough: the sides disagree" if gain.rough else ""
        lines.append(f"{'  ' + gain.name + why:<44}{told}")
    return lines


def _number(value: float) -> str:
    return f"{value:+.4g}" if math.isfinite(value) else "unknown"
