"""The verb `diff`: what differs between two runs."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from quavsweep.cli.describe import described
from quavsweep.cli.option import PATH
from quavsweep.cli.text import count, say, table
from quavsweep.whole import text_file

if TYPE_CHECKING:
    from quavsweep.difference import Common, Difference, Move, Moved

IDENTICAL = {
    "bytes": "byte for byte the same file",
    "content": "the same content: all data and attributes",
    "data": "the same data in all variables; only attributes differ",
    "": "not the same",
}
MOST = 12  # keys, or variables, that are told one by one; --json has all


@click.command()
@click.argument("first", metavar="A", type=PATH)
@click.argument("second", metavar="B", type=PATH)
@click.option("--json", "as_json", is_flag=True, help="Print all of it as JSON, for other programs.")
@click.option("--csv", "csv", type=PATH, metavar="FILE", help="List the cells that changed; - prints only this table.")
def diff(first: Path, second: Path, as_json: bool, csv: Path | None) -> None:
    """Say which cells changed region from A to B, and how far exponents moved.

    \b
    quavsweep diff results/omega_c results/shorter_step
    quavsweep diff old/result.h5 results/omega_c --csv changed.csv
    quavsweep diff results/a results/b --json | jq .changed

    A and B are folders of runs, finished or not, or result files, over the same axes. Different grids are compared at
    the values that both have. Changes are those from A to B; standard errors are those of both together. Exit 0 means
    that they were compared, whether or not they differ; `--json | jq -e '.identical == "bytes"'` asks for more.

    quavsweep plot A B draws both.
    """
    from quavsweep.difference import compare, find_common, told_of_files
    from quavsweep.result import open_result

    if as_json and str(csv) == "-":
        raise click.UsageError("--json and --csv -: one of them", click.get_current_context())
    results = open_result(first), open_result(second)
    common = find_common(*results)
    if csv is not None:
        _write(common, csv)
        if str(csv) == "-":
            return
    found = told_of_files(compare(common), results, (first, second))
    say(json.dumps(found.to_json()) if as_json else "\n".join(_lines(common, found, (first, second))))


def _write(common: Common, path: Path) -> None:
    """Write the cells that changed."""
    from quavsweep.export import write_changes

    if str(path) == "-":
        write_changes(common, sys.stdout)
        return
    with text_file(path) as stream:
        write_changes(common, stream)


def _lines(common: Common, found: Difference, paths: tuple[Path, Path]) -> Iterator[str]:
    """Yield what differs, for people."""
    yield table(_head(common, found, paths))
    if found.changes:
        yield f"\n{'from':<16}{'to':<16}{'cells':>14}{'%':>8}"
        for change in found.changes:
            share = 100 * change.cells / found.compared
            yield f"{change.before:<16}{change.after:<16}{change.cells:>14,}{share:>8.2f}"
    unit = "" if common.a.sweep.model.time_unit == "1" else f" 1/{common.a.sweep.model.time_unit}"
    if found.moves and found.same:
        yield f"\n|change| of exponents where the region is the same{f',{unit}' if unit else ''}"
        yield f"{'':<9}{'largest':>11}{'median':>11}{'largest':>12}{'median':>12}{'exact in both':>25}"
        yield f"{'exponent':<9}{'':>22}{'in standard errors':>24}{'cells':>14}{'largest':>11}"
        yield from (_move(move) for move in found.moves)
    if found.farthest:
        yield f"\nfarthest where the region is the same{f' [{unit.strip()}]' if unit else ''}"
        yield table((f"{moved.change:+.2e}", _moved(moved)) for moved in found.farthest)
    rest = [*_others(found)]
    if rest:
        yield "\n" + table(rest)


def _head(common: Common, found: Difference, paths: tuple[Path, Path]) -> Iterator[tuple[str, str]]:
    """Yield what is compared, and how many cells changed."""
    for name, path, result in zip("AB", paths, (common.a, common.b), strict=True):
        yield name, f"{path} ({described(result.sweep.name, result.sweep)})"
    yield "files", IDENTICAL[found.identical]
    if found.cells != (found.common, found.common):
        yield "common", f"{count(found.common, 'cell')}, of {found.cells[0]:,} and {found.cells[1]:,}"
    if found.compared < found.common:
        yield "computed", f"{count(found.compared, 'cell')} of these in both"
    if found.compared:
        yield "same", f"{count(found.same, 'cell')}, {100 * found.same / found.compared:.2f} %"
        yield "changed", f"{count(found.changed, 'cell')}, {100 * found.changed / found.compared:.2f} %"


def _move(move: Move) -> str:
    """Return how far an exponent moved, as a row."""
    sizes = [_number(size, move.cells) for size in (move.largest, move.median)]
    errors = [_number(size, move.with_error) for size in (move.largest_in_errors, move.median_in_errors)]
    row = f"{move.exponent:<9}{sizes[0]:>11}{sizes[1]:>11}{errors[0]:>12}{errors[1]:>12}"
    row += f"{move.exact:>14,}{_number(move.largest_exact, move.exact):>11}"
    return row + (f"\n{'':<9}{count(move.missing, 'cell')} with a number in only one" if move.missing else "")


def _number(value: float, cells: int) -> str:
    """Return a number in few digits; a dash if no cell has it."""
    return f"{value:.2g}" if cells else "-"


def _moved(moved: Moved) -> str:
    """Return a cell that moved, and which exponent of it."""
    at = ", ".join(f"{name} = {value:.10g}" for name, value in moved.values.items()) or "the cell"
    errors = "" if moved.in_errors != moved.in_errors else f", {moved.in_errors:.2g} standard errors"
    return f"exponent {moved.exponent} at {at} ({moved.region}{errors})"


def _others(found: Difference) -> Iterator[tuple[str, str]]:
    """Yield what else differs."""
    from quavsweep.provenance import shown

    if any(one != other for one, other in found.status.values()):
        pairs = ((name, one, other) for name, (one, other) in found.status.items())
        yield "status", ", ".join(f"{n} {i:,}" + (f" -> {j:,}" if i != j else "") for n, i, j in pairs)
    keys = list(found.config.items())
    for key, (one, other) in keys[:MOST]:
        yield "config", f"{key}: {shown(one)} -> {shown(other)}"
    if len(keys) > MOST:
        yield "config", f"and {count(len(keys) - MOST, 'key')} more"
    if found.variables:
        listed = [f"{name} {cells:,}" for name, cells in found.variables.items()]
        more = [f"and {len(listed) - MOST} more"] if len(listed) > MOST else []
        yield "bits", f"differ in so many cells: {', '.join([*listed[:MOST], *more])}"
    for name, only in zip("AB", found.alone, strict=True):
        if only:
            yield f"only {name}", ", ".join(only)
    if not found.engine:
        yield "made by", "another engine or model"
    if not found.toolchain:
        yield "made with", "other compilers or libraries, or on another kind of processor"
