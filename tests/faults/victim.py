"""The process under attack: the command line on a sweep, in small tiles in a random order.

It is forked from a server that has everything imported and compiled, so that a case takes less than a second.
"""

from __future__ import annotations

import os
import random
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import quavsweep.overview
import quavsweep.plot
import quavsweep.result
import quavsweep.store.outcome
import quavsweep.store.shard_set
import quavsweep.sweep
import quavsweep.verify
import quavsweep.work
from quavsweep.cli import main
from quavsweep.kernels.compiler import default_lanes
from quavsweep.plan import make_plan
from quavsweep.provenance import identify
from tests.faults.probe import Probe
from tests.faults.subject import SUBJECTS, Subject


def warm() -> None:
    """Load the kernels and whatever else a run reads once."""
    for subject in SUBJECTS:
        make_plan(subject.sweep, default_lanes())
        identify(subject.sweep)


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
    sweep, work, shard_set = quavsweep.sweep, quavsweep.work, quavsweep.store.shard_set
    sweep.choose_tile_cells = lambda plan: subject.tile_cells
    rng = random.Random(seed)
    sweep.spread = lambda tiles: rng.sample(found := list(tiles), len(found))
    work.integrate_tile = probe.around("integrating", work.integrate_tile)
    work.continue_cells = probe.around("integrating", work.continue_cells)
    shard_set.write_shard = probe.around("publishing", shard_set.write_shard)
    sweep.write_outcome = probe.around("consolidating", sweep.write_outcome)


if __name__ != "__main__":
    warm()
