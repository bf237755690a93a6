"""The verbs `run`, `extend` and `classify`: from a config to a result."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from quavsweep.cli.describe import described, shares
from quavsweep.cli.option import PATH, Seconds, changes_option, model_option
from quavsweep.cli.stop import stop_on_signals
from quavsweep.cli.text import amount, count, duration, say, table, warn
from quavsweep.errors import ConfigError, QuavsweepError, TilesFailedError

if TYPE_CHECKING:
    from quavsweep.config import Sweep
    from quavsweep.executor import Executor
    from quavsweep.step_check import StepError


workers_option = click.option(
    "--workers", type=click.IntRange(1, 256), default=2, show_default=True, help="Number of threads."
)
max_time_option = click.option(
    "--max-time", type=Seconds(), metavar="TIME", help="Stop after 3h50m, 03:50:00 or so many seconds (exit 75)."
)
no_plot_option = click.option("--no-plot", is_flag=True, help="Do not draw map.png at the end.")


@click.command()
@click.argument("config", type=PATH)
@click.option("--out", type=PATH, metavar="DIR", help="Folder of the run; default results/<name>.")
@changes_option
@model_option
@workers_option
@click.option("--processes", type=click.IntRange(1, 256), help="Use so many processes of this machine instead.")
@click.option("--scheduler", metavar="ADDR", help="Use the cluster of this dask scheduler, tcp:// or tls://.")
@click.option("--scheduler-file", type=PATH, metavar="F", help="The same, by the file that the scheduler writes.")
@click.option("--insecure", is_flag=True, help="Allow tcp:// to another machine.")
@click.option(
    "--worker-timeout", type=Seconds(), metavar="TIME", help="For how long to wait for workers; default 10min."
)
@click.option("--dry-run", is_flag=True, help="Only say what is done and missing, and what the rest would cost.")
@max_time_option
@no_plot_option
@click.option("--accept-toolchain", is_flag=True, help="Start anew where other library versions left evidence.")
@click.option("--retry-failed", is_flag=True, help="Try tiles again that raised in an earlier run.")
@click.option("--fail-fast", is_flag=True, help="Stop at the first tile that raises (exit 3).")
@click.option("--no-lock", is_flag=True, help="For file systems without locks: do not guard against a second run.")
def run(
    config: Path,
    out: Path | None,
    changes: tuple[str, ...],
    model: Path | None,
    workers: int,
    processes: int | None,
    scheduler: str | None,
    scheduler_file: Path | None,
    insecure: bool,
    worker_timeout: float | None,
    dry_run: bool,
    max_time: float | None,
    no_plot: bool,
    accept_toolchain: bool,
    retry_failed: bool,
    fail_fast: bool,
    no_lock: bool,
) -> None:
    """Run the sweep of a CONFIG file, or what is missing of it.

    \b
    quavsweep run configs/omega_c.yaml
    quavsweep run configs/omega_c.yaml --set axes.c.num=41 --out results/quick
    quavsweep run configs/omega_c.yaml --dry-run
    quavsweep run configs/omega_c.yaml --max-time 3h50m    in a batch job
    quavsweep run my_config.yaml --model my_model.py       a model of your own

    Ctrl-C stops it (exit 75); the same command continues it.
    """
    begin = time.monotonic()
    stop = stop_on_signals(max_time)
    from quavsweep.config import load_sweep

    sweep = load_sweep(config, changes, model)
    for warning in sweep.warnings:
        warn(f"warning: {config}: {warning}")
    cluster = _cluster(processes, scheduler, scheduler_file, insecure, worker_timeout)
    if dry_run:
        _preview(sweep, out, processes or workers, stop)
        return
    from quavsweep.cli.progress import show_progress
    from quavsweep.sweep import run_sweep

    failure = None
    with cluster as executor, show_progress(sweep.name) as shown:
        try:
            run_sweep(
                sweep,
                out,
                workers=workers,
                executor=executor,
                observe=shown,
                stop=stop,
                accept_toolchain=accept_toolchain,
                exclusive=not no_lock,
                retry_failed=retry_failed,
                fail_fast=fail_fast,
            )
        except TilesFailedError as error:
            if fail_fast:
                raise
            failure = error
    accuracy = _accuracy(sweep, shown.step_error)
    _finish(out or sweep.folder, sweep.name, time.monotonic() - begin, shown.cells_run, not no_plot, accuracy)
    if failure is not None:
        raise failure


def _cluster(
    processes: int | None,
    scheduler: str | None,
    scheduler_file: Path | None,
    insecure: bool,
    worker_timeout: float | None,
) -> contextlib.AbstractContextManager[Executor | None]:
    """Return the cluster that was asked for, as a context; one of None if tiles run on threads."""
    places = {"--processes": processes, "--scheduler": scheduler, "--scheduler-file": scheduler_file}
    chosen = [name for name, value in places.items() if value is not None]
    details = {"--insecure": insecure or None, "--worker-timeout": worker_timeout}
    idle = [name for name, value in details.items() if value is not None]
    threads = click.get_current_context().get_parameter_source("workers") is not ParameterSource.DEFAULT
    if idle and not chosen:
        raise ConfigError(f"{idle[0]} is for a cluster, and tiles run on threads", possible=f"with {', '.join(places)}")
    if len(chosen) + bool(chosen and threads) > 1:
        both = " and ".join([*chosen, *(["--workers"] if threads else [])])
        raise ConfigError(f"{both} exclude each other", possible="one of them")
    if not chosen:
        return contextlib.nullcontext()
    try:
        from quavsweep.executor.cluster import Cluster
    except ImportError:
        raise ConfigError(f"{chosen[0]} needs dask.distributed", possible="pip install 'quavsweep[cluster]'") from None
    return Cluster(scheduler or "", scheduler_file, processes or 0, insecure, worker_timeout)


@click.command()
@click.argument("folder", metavar="DIR", type=PATH)
@click.option("--duration", type=float, required=True, metavar="T", help="The new duration, after the transient.")
@model_option
@workers_option
@max_time_option
@no_plot_option
def extend(
    folder: Path, duration: float, model: Path | None, workers: int, max_time: float | None, no_plot: bool
) -> None:
    """Take the run in DIR on to a longer duration, from its checkpoints.

    \b
    quavsweep extend results/omega_c --duration 9000

    The result equals that of a run of this duration from the start, to the byte. Ctrl-C stops it (exit 75); the same
    command continues it.
    """
    begin = time.monotonic()
    stop = stop_on_signals(max_time)
    from quavsweep.cli.progress import show_progress
    from quavsweep.sweep import extend_sweep

    failure = None
    with show_progress(folder.name) as shown:
        try:
            extend_sweep(folder, duration, model=model, workers=workers, observe=shown, stop=stop)
        except TilesFailedError as error:
            failure = error
    _finish(folder, "", time.monotonic() - begin, shown.cells_run, not no_plot)
    if failure is not None:
        raise failure


@click.command()
@click.argument("folder", metavar="DIR", type=PATH)
@changes_option
@click.option("--no-plot", is_flag=True, help="Do not draw map.png anew.")
def classify(folder: Path, changes: tuple[str, ...], no_plot: bool) -> None:
    """Label the cells of the run in DIR anew, from what is stored.

    \b
    quavsweep classify results/omega_c --set classify.errors=4

    Nothing is integrated. Thresholds are those of DIR/config.yaml, changed by --set; they are kept there.
    """
    stop = stop_on_signals(None, "begins anew")
    from quavsweep.sweep import reclassify

    begin = time.monotonic()
    path = reclassify(folder, changes, stop)
    _finish(path.parent, "", time.monotonic() - begin, 0, not no_plot)


def _accuracy(sweep: Sweep, error: StepError | None) -> list[tuple[str, str]]:
    """Return the row that says how far the step can be trusted, and warn if it is too long."""
    if error is None:
        return []
    unit, tolerance = sweep.unit_of_time, sweep.config.integrate.tolerance
    text = f"{error.median:.1e} of a state after {error.time:g}{unit}, at most {error.largest:.1e}"
    if error.median > tolerance:
        said = f"warning: steps of {error.dt:g}{unit} cause an error of {text}, in {count(error.cells, 'regular cell')}"
        warn(f"{said}; integrate.tolerance is {tolerance:g}: a shorter integrate.dt")
    return [("error by dt", text)]


def _finish(
    folder: Path,
    name: str,
    seconds: float,
    cells_run: int,
    with_plot: bool,
    accuracy: Sequence[tuple[str, str]] = (),
) -> None:
    """Print what was found, and draw it."""
    from quavsweep.result import open_result
    from quavsweep.store import RunFolder, strangers

    result = open_result(folder / "result.h5")
    made_by = result.stored.file_attributes
    for sentence in strangers(RunFolder(folder), made_by["evidence_id"], made_by["toolchain_id"]):
        warn(f"warning: {sentence}")
    rows = [*shares(result), *accuracy, ("time", _speed(seconds, cells_run)), ("result", str(folder / "result.h5"))]
    if with_plot:
        from quavsweep.plot import draw

        try:
            rows.append(("map", str(draw(result, folder / "map.png"))))
        except QuavsweepError as error:
            rows.append(("no map", str(error)))
    say(table([("sweep", described(name or result.sweep.name, result.sweep)), *rows]))


def _speed(seconds: float, cells: int) -> str:
    if not cells:
        return f"{duration(seconds)}; nothing had to be integrated"
    return duration(seconds) + (f", {cells / seconds:,.0f} cells/s" if cells >= seconds else "")


def _preview(sweep: Sweep, out: Path | None, workers: int, stop: threading.Event) -> None:
    """Print what a run would do."""
    from quavsweep.preview import preview_run

    preview = preview_run(sweep, out, workers, stop)
    steps = "" if not preview.missing else f", about {preview.steps_per_cell:,.0f} of {sweep.clock.steps:,} steps each"
    rows = [
        ("sweep", described(sweep.name, sweep) + steps),
        ("tiles", f"{preview.valid:,} valid, {preview.missing:,} missing, {len(preview.bad):,} bad"),
        *(("bad", sentence) for sentence in preview.bad[:10]),
        ("time", f"about {duration(preview.seconds)} with {count(workers, 'worker')}"),
        ("disk", _disk(preview.shard_bytes, preview.result_bytes, preview.free_bytes)),
        ("checks", "every parameter is in its domain" + ("; see the warnings above" if sweep.warnings else "")),
        ("folder", str(out or sweep.folder)),
    ]
    say(table(rows))


def _disk(shards: int, result: int, free: int) -> str:
    short = "; NOT ENOUGH" if shards + result > free else ""
    return f"{amount(shards)} for shards, at most {amount(result)} for the result; {amount(free)} free{short}"
