"""The verb `paper`: the paper's figures and tables, computed, checked and drawn."""

from __future__ import annotations

import time
from pathlib import Path

import click

from quavsweep.cli.option import PATH
from quavsweep.cli.run import max_time_option, workers_option
from quavsweep.cli.stop import stop_on_signals
from quavsweep.cli.text import duration, say, table, warn
from quavsweep.errors import TilesFailedError


@click.command()
@click.option("--out", type=PATH, metavar="DIR", help="Folder of runs, figures, report; default results/paper.")
@click.option("--only", multiple=True, metavar="ITEM", help="Only this figure or table, as figure_03; may be repeated.")
@click.option("--quick", is_flag=True, help="Thumbnails of all grids, in two minutes, into results/paper-quick.")
@workers_option
@max_time_option
def paper(out: Path | None, only: tuple[str, ...], quick: bool, workers: int, max_time: float | None) -> None:
    """Compute, check and draw the whole paper.

    \b
    quavsweep paper                      all of it: 17 minutes on 2 cores, 2.6 GB
    quavsweep paper --only figure_03     one of its figures
    quavsweep paper --quick              thumbnails: does everything work?

    What is done is not done again. A figure that fails is named, and the rest goes on (exit 3). Ctrl-C stops it
    (exit 75); the same command continues it.
    """
    begin = time.monotonic()
    stop = stop_on_signals(max_time)
    from quavsweep.cli.progress import show_progress
    from quavsweep.paper import reproduce_paper

    done = reproduce_paper(out, only=only, quick=quick, workers=workers, show=show_progress, tell=warn, stop=stop)
    rows = [(str(verdict), f"{number:>6,}") for verdict, number in done.verdicts.items()]
    rows += [("failed", f"{outcome.item.name}: {outcome.error}") for outcome in done.failed]
    rows += [("time", duration(time.monotonic() - begin)), ("report", str(done.out / "report.md"))]
    say(table([("paper", f"{len(done.outcomes)} figures and tables"), *rows]))
    if done.failed:
        what = f"{len(done.failed)} of {len(done.outcomes)} figures and tables failed"
        raise TilesFailedError(what, str(done.out), "failed/ says why; the rest is in the report")
