"""The process under attack: the command line on a sweep, in small tiles in a random order.

It is forked from a server that has everything imported and compiled, so that a case takes less than a second.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout, suppress
from pathlib import Path

import quavsweep.conductor
import quavsweep.overview
import quavsweep.plot
import quavsweep.result
import quavsweep.store.outcome
import quavsweep.store.shard_set
import quavsweep.sweep
import quavsweep.verify
import quavsweep.work
from quavsweep.cli import main
from tests.faults.probe import Probe
from tests.faults.subject import SUBJECTS, Subject

STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)


def warm() -> None:
    """Run the sweeps once, so that what is forked from here has read, imported and compiled everything."""
    handlers = {number: signal.getsignal(number) for number in STOPS}
    with tempfile.TemporaryDirectory() as folder, open(os.devnull, "w") as nowhere:
        for subject in SUBJECTS:
            config = Path(folder) / f"{subject.name}.yaml"
            config.write_text(subject.text)
            sys.argv = ["quavsweep", "run", str(config), "--out", f"{folder}/{subject.name}", "--no-plot"]
            with redirect_stdout(nowhere), redirect_stderr(nowhere), suppress(SystemExit):
                main()
    for number, handler in handlers.items():
        signal.signal(number, handler)


def attend(
    subject: Subject,
    arguments: Sequence[str],
    folder: Path,
    seed: int,
    gated: bool,
    prepare: Callable[[], None] | None = None,
) -> None:
    """Carry out a command on a sweep; what it prints goes to a file.

    Parameters
    ----------
    folder : Path
        For the files `out` and `probe`.
    seed : int
        Of the order of tiles.
    gated : bool
        Whether to stop itself first, until it is told to go on.
    prepare : callable
        Called before.
    """
    handle = os.open(folder / "out", os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    os.dup2(handle, 1)
    os.dup2(handle, 2)
    sys.stdout, sys.stderr = (open(number, "w", closefd=False, buffering=1) for number in (1, 2))  # noqa: SIM115
    _arrange(subject, Probe(folder / "probe"), seed)
    sys.argv = ["quavsweep", *arguments]
    if prepare is not None:
        prepare()
    if gated:
        os.kill(os.getpid(), signal.SIGSTOP)
    code = 1
    try:
        main()
    except SystemExit as error:
        code = int(error.code or 0)
    finally:
        os._exit(code)


def _arrange(subject: Subject, probe: Probe, seed: int) -> None:
    """Put tiles in a random order, and tell what is going on."""
    rng = random.Random(seed)
    vars(quavsweep.sweep).update(choose_tile_cells=lambda plan: subject.tile_cells)
    vars(quavsweep.conductor).update(spread=lambda tiles: rng.sample(found := list(tiles), len(found)))
    for module, function, name in (
        (quavsweep.work, "integrate_tile", "integrating"),
        (quavsweep.work, "continue_cells", "integrating"),
        (quavsweep.store.shard_set, "write_shard", "publishing"),
        (quavsweep.conductor, "write_outcome", "consolidating"),
    ):
        vars(module)[function] = probe.around(name, vars(module)[function])


if __name__ != "__main__":
    warm()
