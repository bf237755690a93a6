"""F40: every verb without a terminal, or with a poor one: streams closed or full, no locale, 20 columns."""

from __future__ import annotations

import contextlib
import os
import pty
import shutil
import subprocess
import sys
import termios
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.faults.arena import HANG_SECONDS, Arena
from tests.faults.fault import Case, Fault
from tests.faults.subject import SMALL

DISK = 74


@dataclass(frozen=True)
class Terminal:
    """What a command is started in.

    Parameters
    ----------
    name : str
    redirections : str
        Of the shell.
    environment : mapping
    size : tuple of int
        Lines and columns of a terminal on output and error; none if empty.
    """

    name: str
    redirections: str = ""
    environment: Mapping[str, str] = field(default_factory=dict)
    size: tuple[int, int] | tuple[()] = ()

    @property
    def is_full(self) -> bool:
        """Whether what is printed cannot be written."""
        return ">/dev/full" in self.redirections.split()


TERMINALS = (
    Terminal("stdin closed", "<&-"),
    Terminal("stdout closed", ">&-"),
    Terminal("stderr closed", "2>&-"),
    Terminal("all closed", "<&- >&- 2>&-"),
    Terminal("stdout full", ">/dev/full"),
    Terminal("stderr full", "2>/dev/full"),
    Terminal("both full", ">/dev/full 2>/dev/full"),
    Terminal("no stdin, output to nobody", "</dev/null >/dev/null"),
    Terminal("no environment", environment={"LANG": "C", "LC_ALL": "C", "PYTHONIOENCODING": "ascii"}),
    Terminal("20 columns", environment={"COLUMNS": "20", "TERM": "dumb"}),
    Terminal("odd environment", environment={"COLUMNS": "-1", "LINES": "x", "TERM": "none", "LANG": "xx_YY.none"}),
    Terminal("narrow terminal", size=(5, 20), environment={"TERM": "xterm"}),
    Terminal("dumb terminal", size=(24, 80), environment={"TERM": "dumb"}),
    Terminal("terminal without size", size=(0, 0)),
)

# RUN stands for the folder of a finished run, CONFIG for the sweep's config; then comes the exit code.
COMMANDS: tuple[tuple[Sequence[str], int], ...] = (
    (("run", "CONFIG", "--out", "new"), 0),
    (("status", "RUN"), 0),
    (("verify", "RUN"), 0),
    (("export", "RUN", "--csv", "region", "--out", "-"), 0),
    (("plot", "RUN"), 0),
    (("init", "--out", "-"), 0),
    (("schema",), 0),
    (("extend", "RUN", "--duration", "8", "--no-plot"), 0),
    (("classify", "RUN", "--no-plot"), 0),
    (("point", "CONFIG", "rho=28", "--no-plot"), 0),
    (("margin", "CONFIG", "--reach", "1", "--points", "2", "--no-plot"), 0),
    (("paper", "--only", "table_3", "--quick", "--out", "paper"), 0),
    (("run", "CONFIG", "--dry-run"), 0),
    (("status", "RUN", "--json"), 0),
    (("--help",), 0),
    ((), 0),
    (("run", "--help"), 0),
    (("--version",), 0),
    (("run", "none.yaml"), 2),
    (("sing",), 2),
    (("status", "none"), 2),
    (("--traceback", "verify", "none"), 2),
)


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    # Every verb and every terminal before any comes again, then every pair.
    first = arena.rng.randrange(len(TERMINALS))
    for number in range(cases):
        turn, within = divmod(number, len(COMMANDS))
        terminal, (words, code) = TERMINALS[(first + within + turn) % len(TERMINALS)], COMMANDS[within]
        with arena.place() as place:
            shutil.copytree(arena.undisturbed(SMALL).run, place / "run")
            known = {"CONFIG": str(arena.config(SMALL)), "RUN": "run"}
            ended, told = _carried_out(terminal, [known.get(word, word) for word in words], place)
        wanted = DISK if terminal.is_full and code == 0 else code
        shown = "Traceback" in told and "--traceback" not in words
        note = "" if ended == wanted and not shown else f"exit {ended} instead of {wanted}: {told[-300:]}"
        label = f"{terminal.name}, {' '.join(words)}"
        yield Case(not note, f"{label}: {note}" if note else "", kinds=(terminal.name,))


def _carried_out(terminal: Terminal, words: Sequence[str], place: Path) -> tuple[int, str]:
    """Return exit code and output of a command."""
    shell = ["sh", "-c", f'exec "$@" {terminal.redirections}', "sh", sys.executable, "-m", "quavsweep", *words]
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": root, **terminal.environment}
    if terminal.size:
        return _on_terminal(terminal.size, shell, environment, place)
    done = subprocess.run(
        shell, cwd=place, env=environment, capture_output=True, errors="replace", timeout=HANG_SECONDS, check=False
    )
    return done.returncode, done.stdout + done.stderr


def _on_terminal(
    size: tuple[int, int], shell: Sequence[str], environment: Mapping[str, str], place: Path
) -> tuple[int, str]:
    """Return exit code and output of a command that a terminal of so many lines and columns shows."""
    main, side = pty.openpty()
    termios.tcsetwinsize(side, size)
    with subprocess.Popen(shell, cwd=place, env=environment, stdin=side, stdout=side, stderr=side) as child:
        os.close(side)
        shown = b""
        with contextlib.suppress(OSError):
            while data := os.read(main, 4096):
                shown += data
        code = child.wait(HANG_SECONDS)
    os.close(main)
    return code, shown.decode(errors="replace")


FAULTS = (Fault("F40", "streams closed or full, no locale, no terminal, 20 columns", 12, 110, _attack),)
