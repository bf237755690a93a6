"""Where sweeps are run: each in a folder of its own, so that what has been run once is only read again."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from quavsweep import Result, Sweep, open_result, parse_sweep, run_sweep
from quavsweep.config import dump_config
from quavsweep.measures import BASE, Evidence
from quavsweep.provenance import identify
from quavsweep.store import RunFolder, ShardSet

Value = TypeVar("Value")
KEPT = ("cell", "status", "steps", "state")  # of the evidence that every sweep has, what is no certificate


@dataclass(frozen=True)
class Laboratory:
    """Runs sweeps for rows.

    Parameters
    ----------
    folder : Path
        Folders of runs lie in it.
    quick : bool
        Whether small numbers are enough, to see that a row works.
    workers : int
        Threads of a run.
    """

    folder: Path
    quick: bool = False
    workers: int = 2

    def choose(self, full: Value, quick: Value) -> Value:
        """Return a value for the row as it is meant, or a small one."""
        return quick if self.quick else full

    def path(self, name: str) -> Path:
        """Return the folder of a run."""
        return self.folder / ("quick" if self.quick else "full") / name

    def run(self, name: str, sweep: Sweep) -> Result:
        """Run a sweep, or what is missing of it, in the folder of that name."""
        return open_result(run_sweep(sweep, self.path(name), workers=self.workers))

    def evidence(self, name: str, sweep: Sweep) -> Evidence:
        """Return what the complete run of that name has stored."""
        return stored_evidence(self.path(name), sweep)


def stored_evidence(folder: Path, sweep: Sweep) -> Evidence:
    """Return what a complete run has stored of all its cells, in order."""
    shards = ShardSet.scan(RunFolder(folder), sweep, identify(sweep), 1)
    parts = [shards.read(index, {}) for index in range(shards.tiles)]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def changed(sweep: Sweep, *changes: str) -> Sweep:
    """Return a sweep with the batches and segments of another, and some keys changed, as in `--set`."""
    return parse_sweep(dump_config(sweep.canonical()), changes=changes)


def take(evidence: Evidence, cells: np.ndarray) -> Evidence:
    """Return the evidence of some cells."""
    return {name: values[cells] for name, values in evidence.items()}


def without_certificates(sweep: Sweep, evidence: Evidence) -> Evidence:
    """Return evidence of cells that were integrated to the end, with all that is certified of them left out."""
    n = len(evidence["cell"])
    blank = {v.name: v.empty(n, sweep.extents) for v in BASE if v.name not in KEPT}
    return {**evidence, **blank}


def described(sweep: Sweep) -> str:
    """Return model, initial state, method, dt and T in words."""
    axes = {axis.name: _along(axis.values) for axis in sweep.grid.axes}
    fixed = {**sweep.config.parameters, **sweep.config.initial}
    fixed = {name: value for name, value in fixed.items() if sweep.model.defaults.get(name) != value}
    where = [*(f"{n} {along}" for n, along in axes.items()), *(f"{n} = {v:g}" for n, v in fixed.items())]
    integrate, clock = sweep.config.integrate, sweep.clock
    after = f" after {clock.transient:,.6g}" if clock.transient else ""
    time = f"T = {clock.duration:,.6g}{after}{sweep.unit_of_time}"
    early = "" if sweep.config.stop_early else "; no early ends"
    return f"{sweep.model.name}: {', '.join(where)}; {integrate.method}, dt = {clock.dt:g}; {time}{early}"


def _along(values: tuple[float, ...]) -> str:
    if len(values) <= 4:
        return ", ".join(f"{value:g}" for value in values)
    return f"{min(values):g} .. {max(values):g} ({len(values)})"
