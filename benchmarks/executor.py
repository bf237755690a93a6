"""The suite `executor`: the same sweep on worker processes and on threads, start-up apart."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.protocol import Contender, MissingError, Protocol, compare, ratios
from benchmarks.row import Measurement, Row, at_most
from benchmarks.sweep import OMEGA_C
from quavsweep import load_sweep
from quavsweep.executor import Executor
from quavsweep.sweep import run_sweep

WORKERS = 2
LONG = ("stop_early=false", "axes.Omega1.num=320", "axes.c.num=100", "integrate.duration=13000")
QUICK = ("stop_early=false", "axes.Omega1.num=60", "axes.c.num=40", "integrate.duration=3000")
WARM = ("axes.Omega1.num=8", "axes.c.num=4")


@dataclass
class Runs:
    """A sweep that is run from scratch each time it is called, on threads of this process or somewhere else."""

    changes: Sequence[str]
    folder: Path
    executor: Executor | None = None
    digests: list[str] = field(default_factory=list)

    def __call__(self) -> None:
        """Run it."""
        path = self._result(self.changes)
        self.digests.append(hashlib.sha256(path.read_bytes()).hexdigest())
        shutil.rmtree(path.parent)

    def warm(self) -> None:
        """Have kernels loaded wherever they are needed."""
        shutil.rmtree(self._result(WARM).parent)

    def _result(self, changes: Sequence[str]) -> Path:
        return run_sweep(load_sweep(OMEGA_C, changes), self.folder, workers=WORKERS, executor=self.executor)


def processes_over_threads(protocol: Protocol) -> Measurement:
    """Wall of a sweep on two processes over that on two threads, run in turn; their bytes must be the same."""
    try:
        from quavsweep.executor.cluster import Cluster  # noqa: PLC0415 # an extra
    except ImportError:
        raise MissingError("dask.distributed is not installed") from None
    changes = QUICK if protocol.quick else LONG
    with tempfile.TemporaryDirectory() as folder, Cluster(processes=WORKERS) as cluster:
        sides = {"processes": Runs(changes, Path(folder, "a"), cluster), "threads": Runs(changes, Path(folder, "b"))}
        for side in sides.values():
            side.warm()
        samples = compare([Contender(name, side, 1e9, once=True) for name, side in sides.items()], protocol)
    if len({digest for side in sides.values() for digest in side.digests}) != 1:
        raise RuntimeError("results differ")
    values = ratios(samples, *sides)
    walls = " against ".join(f"{np.median(wall):.1f} s" for wall in samples.values())
    note = f"{walls}; ratios {min(values):.3f} .. {max(values):.3f}; the same bytes"
    return Measurement(values, samples, "s per run", note, comparable=not protocol.quick)


ROWS = (Row("processes", "executor", "2 processes / 2 threads", "x", at_most(1.1), processes_over_threads),)
