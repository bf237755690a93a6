"""The command line: verbs, exit codes, messages. Everything heavy is imported when its verb runs."""

from __future__ import annotations

import os
import signal
import sys
import threading
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from quavsweep.errors import ConfigError, DamageError, QuavsweepError

if TYPE_CHECKING:
    from quavsweep.result import Result

EXIT_BUG = 1
EXIT_USAGE = 2
EXIT_DISK = 74
EXIT_SECOND_INTERRUPT = 130


@click.group(invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="quavsweep")
@click.option("--traceback", is_flag=True, help="Show where in the program an error arose.")
@click.pass_context
def cli(context: click.Context, traceback: bool) -> None:
    """Sweep the parameters of a dynamical system and say where its orbits end.

    \b
    quavsweep run configs/omega_c.yaml      run a sweep, or continue it
    quavsweep status results/omega_c        how far it is
    quavsweep plot results/omega_c          draw its map, finished or not
    """
    if context.invoked_subcommand is None:
        _say(context.get_help())


@cli.command()
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Folder of the run; default results/<name>.")
@click.option("--workers", type=click.IntRange(1, 256), default=2, show_default=True, help="Number of threads.")
@click.option("--no-plot", is_flag=True, help="Do not draw map.png at the end.")
def run(config: Path, out: Path | None, workers: int, no_plot: bool) -> None:
    """Run the sweep of a CONFIG file, or what is missing of it."""
    from quavsweep.cli.progress import show_progress
    from quavsweep.config import load_sweep
    from quavsweep.sweep import run_sweep

    sweep = load_sweep(config)
    for warning in sweep.warnings:
        click.echo(f"warning: {config}: {warning}", err=True)
    stop = _stop_on_signals()
    with show_progress(sweep.name) as observe:
        path = run_sweep(sweep, out, workers=workers, observe=observe, stop=stop)
    from quavsweep.result import open_result

    result = open_result(path)
    _say(_shares(result))
    _say(f"result  {path}")
    if not no_plot:
        from quavsweep.plot import draw

        try:
            _say(f"map     {draw(result, path.with_name('map.png'))}")
        except ConfigError as error:
            _say(f"no map: {error}")


@cli.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def status(folder: Path) -> None:
    """Say how far the run in DIR is, and what it found."""
    from quavsweep.config import load_sweep
    from quavsweep.provenance import identify
    from quavsweep.store import RunFolder, ShardSet

    run_folder = RunFolder(folder)
    if not run_folder.config.is_file():
        raise ConfigError("is not the folder of a run", str(folder), "it has no config.yaml")
    sweep = load_sweep(run_folder.config)
    shards = ShardSet.scan(run_folder, sweep, run_folder.present_identity(identify(sweep)), 0)
    _say(f"sweep   {sweep.name}: {sweep.model.name}, {' x '.join(map(str, sweep.grid.shape)) or 1} cells")
    if not shards.tile_cells:
        _say("tiles   none done")
        return
    missing = shards.missing()
    cells = sweep.grid.size
    done = cells - sum(len(tile) for tile in missing)
    click.echo(
        f"tiles   {shards.tiles - len(missing)} of {shards.tiles} done ({100 * done / cells:.1f} % of the cells)"
    )
    if run_folder.result.exists():
        from quavsweep.result import open_result

        _say(_shares(open_result(run_folder.result)))
        _say(f"result  {run_folder.result}")
    else:
        _say("result  not written yet")


@cli.command()
@click.argument("source", metavar="DIR|FILE", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="PNG, PDF or SVG file; default map.png beside the result.")
def plot(source: Path, out: Path | None) -> None:
    """Draw a run, finished or not, or a result file."""
    from quavsweep.plot import draw
    from quavsweep.result import open_result

    folder = source if source.is_dir() else source.parent
    _say(draw(open_result(source), out or folder / "map.png"))


@cli.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def verify(folder: Path) -> None:
    """Check every stored byte of the run in DIR against its digest."""
    from quavsweep.verify import verify_folder

    verdict = verify_folder(folder)
    for sentence in verdict.damaged:
        click.echo(sentence, err=True)
    if verdict.damaged:
        raise DamageError(f"{len(verdict.damaged)} damaged", str(folder), "run the sweep again to repair it")
    tail = "a result" if verdict.result else "no result yet"
    missing = "no tile done" if verdict.missing < 0 else f"{verdict.missing} tiles missing"
    _say(f"{folder}: {verdict.shards} shards and {tail}, nothing damaged, {missing}")


def _say(text: object) -> None:
    """Print a line; that nobody reads it is no reason to stop."""
    try:
        click.echo(text)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError, AttributeError):
        pass


def _shares(result: Result) -> str:
    """Return a line that says how the cells are shared out among the regions."""
    import numpy as np

    from quavsweep.codes import REGION

    count = np.bincount(result["region"].ravel(), minlength=len(REGION))
    parts = [f"{code.meaning} {n}" for code, n in zip(REGION, count, strict=True) if n]
    return f"cells   {', '.join(parts)}"


def _stop_on_signals() -> threading.Event:
    """Return an event that Ctrl-C, SIGTERM and SIGHUP set; a second Ctrl-C ends the process at once."""
    stop = threading.Event()

    def handle(number: int, frame: Any) -> None:
        if stop.is_set() and number == signal.SIGINT:
            os._exit(EXIT_SECOND_INTERRUPT)
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, handle)
    return stop


def main() -> NoReturn:
    """Run the command and exit with the code that fits what happened."""
    sys.exit(_main())


def _main() -> int:
    show = "--traceback" in sys.argv
    arguments = [argument for argument in sys.argv[1:] if argument != "--traceback"]
    try:
        cli.main(args=arguments, prog_name="quavsweep", standalone_mode=False)
    except (Exception, KeyboardInterrupt) as error:
        if show:
            traceback.print_exc()
        message, code = _explain(error)
        click.echo(f"quavsweep: {message}", err=True)
        return code
    return 0


def _explain(error: BaseException) -> tuple[str, int]:
    """Return the sentence and the exit code of an error."""
    if isinstance(error, QuavsweepError):
        return str(error), error.exit_code
    if isinstance(error, click.ClickException):
        context = getattr(error, "ctx", None)
        return error.format_message() + (f" (see {context.command_path} --help)" if context else ""), EXIT_USAGE
    if isinstance(error, click.Abort | KeyboardInterrupt):
        return "interrupted", EXIT_SECOND_INTERRUPT
    if isinstance(error, OSError):
        return f"{error.filename or 'the disk'}: {error.strerror or error}", EXIT_DISK
    return f"this is a bug in quavsweep: {type(error).__name__}: {error}; --traceback shows where", EXIT_BUG
