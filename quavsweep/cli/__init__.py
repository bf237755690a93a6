"""The command line: verbs, exit codes, messages. Everything heavy is imported when its verb runs."""

from __future__ import annotations

import sys
import traceback
from typing import NoReturn

import click

from quavsweep.cli.diff import diff
from quavsweep.cli.draw import plot, point
from quavsweep.cli.look import export, status, verify
from quavsweep.cli.margin import margin
from quavsweep.cli.paper import paper
from quavsweep.cli.run import classify, extend, run
from quavsweep.cli.stop import leave
from quavsweep.cli.text import EXIT_SECOND_INTERRUPT, deafen, drain, prepare_streams, say, warn
from quavsweep.cli.write import init, schema
from quavsweep.errors import QuavsweepError

EXIT_BUG = 1
EXIT_USAGE = 2
EXIT_DISK = 74


class _InOrder(click.Group):
    """A group whose commands are listed in the order in which people use them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)

    def invoke(self, ctx: click.Context) -> None:
        """Run a command; that nobody reads what it prints is no error."""
        try:
            super().invoke(ctx)
        except BrokenPipeError:
            deafen()


@click.group(cls=_InOrder, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="quavsweep")
@click.option("--traceback", is_flag=True, help="Show where in the program an error arose; works after any command.")
@click.pass_context
def cli(context: click.Context, traceback: bool) -> None:
    """Sweep the parameters of a dynamical system and say where its orbits end.

    \b
    A first sweep:
      quavsweep init                          write a commented config
      quavsweep run quadrotor_yaw.yaml --dry-run    how long it will take
      quavsweep run quadrotor_yaw.yaml        run it; again: continue it
      quavsweep point results/quadrotor_yaw Omega1=240 c=5    one cell of it
      quavsweep plot results/quadrotor_yaw --variable settle_time

    \b
    Exit codes: 0 complete, 1 a bug, 2 wrong command or config, 3 tiles failed,
    4 folder of another sweep, 5 folder in use, 6 damaged files, 74 disk,
    75 stopped: the same command goes on, 130 interrupted at once.

    \b
    Completion for bash (zsh, fish alike), in ~/.bashrc:
      eval "$(_QUAVSWEEP_COMPLETE=bash_source quavsweep)"
    """
    if context.invoked_subcommand is None:
        say(context.get_help())


for verb in (init, run, extend, status, plot, point, classify, verify, diff, export, margin, schema, paper):
    cli.add_command(verb)


def main() -> NoReturn:
    """Run the command and exit with the code that fits what happened."""
    code = _main()
    leave(code if drain() else code or EXIT_DISK)


def _main() -> int:
    prepare_streams()
    show = "--traceback" in sys.argv
    arguments = [argument for argument in sys.argv[1:] if argument != "--traceback"]
    try:
        cli.main(args=arguments, prog_name="quavsweep", standalone_mode=False)
    except (Exception, KeyboardInterrupt) as error:
        if show:
            warn(traceback.format_exc().rstrip())
        message, code = _explain(error)
        sentence = message.replace("\n", "\\n")  # that may be in the name of a file
        warn(f"quavsweep: {sentence}")
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
