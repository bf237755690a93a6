"""The verbs `status`, `verify` and `export`: what a folder holds."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from quavsweep.cli.describe import described
from quavsweep.cli.option import PATH
from quavsweep.cli.text import say, table, warn
from quavsweep.errors import ConfigError, DamageError, StoppedError
from quavsweep.whole import is_special, text_file

if TYPE_CHECKING:
    from quavsweep.overview import Lookout, Overview

WATCH_SECONDS = 2.0


@click.command()
@click.argument("folder", metavar="DIR", type=PATH)
@click.option("--json", "as_json", is_flag=True, help="Print it as JSON, for other programs.")
@click.option("--watch", is_flag=True, help="Look every 2 s until the run ends.")
def status(folder: Path, as_json: bool, watch: bool) -> None:
    """Say how far the run in DIR is, and what it found so far.

    \b
    quavsweep status results/omega_c
    quavsweep status results/omega_c --watch
    quavsweep status results/omega_c --json | jq .regions.chaos
    """
    from quavsweep.overview import Lookout

    lookout = Lookout.of(folder)
    if watch:
        _watch(lookout, as_json)
        return
    overview = lookout.look()
    for sentence in overview.ignored:
        warn(f"warning: {sentence}")
    say(_shown(overview, as_json))


def _shown(overview: Overview, as_json: bool) -> str:
    """Return what a folder holds, as text or as a line of JSON."""
    if as_json:
        return json.dumps(overview.to_json())
    sweep = overview.sweep
    cells = sweep.grid.size
    rows = [
        ("sweep", described(sweep.name, sweep)),
        (
            "tiles",
            f"{overview.tiles_done} of {overview.tiles} done ({100 * overview.cells_done / cells:.1f} % of cells)",
        )
        if overview.tiles
        else ("tiles", "none done"),
    ]
    if overview.looked_at:
        partial = "" if overview.looked_at == cells else f"  (of {overview.looked_at:,} cells)"
        shares = (f"{name} {100 * n / overview.looked_at:.1f} %" for name, n in overview.regions.items())
        rows.append(("regions", ", ".join(shares) + partial))
    if overview.failed:
        rows.append(("failed", f"{overview.failed:,} cells, in tiles that raised; failed/ says why"))
    rows.append(("run", overview.holder or ("complete" if overview.complete else "nobody is running it")))
    rows.append(("result", overview.result or overview.damaged or "not written yet"))
    return table(rows)


def _watch(lookout: Lookout, as_json: bool) -> None:
    """Show what a folder holds again and again, until its run ends; on a terminal in the same place."""
    lines = 0
    live = sys.stdout.isatty() and not as_json
    while True:
        overview = lookout.look()
        text = _shown(overview, as_json)
        if live and lines:
            click.echo(f"\033[{lines}F\033[J", nl=False)
        if not say(text):
            return
        lines = text.count("\n") + 1
        if not overview.holder:
            break
        try:
            time.sleep(WATCH_SECONDS)
        except KeyboardInterrupt:
            return
    if not overview.complete:
        raise StoppedError("the run has ended and is not complete", possible="run the sweep to continue it")


@click.command()
@click.argument("folder", metavar="DIR", type=PATH)
@click.option("--trust", is_flag=True, help="Take a run from elsewhere for one of your own, without limits.")
def verify(folder: Path, trust: bool) -> None:
    """Check every stored byte of the run in DIR against its digest.

    \b
    quavsweep verify results/omega_c
    quavsweep verify from_a_colleague --trust

    A result that was not made here is read by a process of its own that can open nothing else, and up to a size only.
    If you know who made it, --trust lifts both.
    """
    from quavsweep.verify import verify_folder

    verdict = verify_folder(folder, trust)
    for sentence in verdict.ignored:
        warn(f"warning: {sentence}")
    for sentence in verdict.damaged:
        warn(sentence)
    if verdict.damaged:
        raise DamageError(f"{len(verdict.damaged)} damaged", str(folder), "run the sweep again to repair it")
    tail = "a result" if verdict.result else "no result yet"
    missing = "no tile done" if verdict.missing < 0 else f"{verdict.missing} tiles missing"
    say(f"{folder}: {verdict.shards} shards and {tail}, nothing damaged, {missing}")


@click.command()
@click.argument("source", metavar="DIR|FILE", type=PATH)
@click.argument("variables", metavar="VARIABLE...", nargs=-1, required=True)
@click.option("--csv", "kind", flag_value="csv", help="A table of text, a row per cell, or per parameter point.")
@click.option("--nc", "kind", flag_value="nc", help="A netCDF-4 file.")
@click.option("--out", type=PATH, metavar="FILE", help="Default VARIABLE.csv or .nc beside the result; - prints CSV.")
def export(source: Path, variables: tuple[str, ...], kind: str | None, out: Path | None) -> None:
    """Write variables of a run for other programs.

    \b
    quavsweep export results/omega_c --csv region lyapunov
    quavsweep export results/lifetime --csv lifetime lifetime_se chaotic_share
    quavsweep export results/omega_c --nc settle_time --out settle_time.nc

    In a table codes are names (sink, chaos ...), and a variable with components has a column for each. result.h5
    itself is netCDF-4, and xarray opens it as it is.
    """
    from quavsweep.export import write_csv, write_netcdf
    from quavsweep.result import open_result
    from quavsweep.store.doubt import doubted

    if kind is None:
        raise click.UsageError("give --csv or --nc", click.get_current_context())
    if out is not None and (out.name == "result.h5" or (kind == "nc" and str(out) == "-")):
        raise click.UsageError(f"--out {out}: choose another name", click.get_current_context())
    result = open_result(source)
    folder = source if source.is_dir() else source.parent
    path = out or folder / f"{variables[0]}.{kind}"
    if kind == "nc" and (is_special(path) or path.is_dir()):
        raise ConfigError("is not a file", str(path), "choose another --out")
    with doubted(source, result.stored.foreign):
        if str(path) == "-":
            write_csv(result, variables, sys.stdout)
            return
        if kind == "nc":
            write_netcdf(result, variables, path.resolve())  # what a link leads to, not the link
        else:
            with text_file(path) as stream:
                write_csv(result, variables, stream)
    say(path)
