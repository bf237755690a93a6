"""The suite `sweep`: whole runs in fresh processes, from the start of the process to `result.h5`."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.cells import yaw_cells
from benchmarks.printed import Printed
from benchmarks.protocol import Contender, Protocol, Samples, compare, ratios
from benchmarks.row import Measurement, Row, at_least, at_most
from quavsweep import load_sweep, open_result

OMEGA_C = Path(__file__).parents[1] / "configs" / "omega_c.yaml"
THUMBNAIL = ("axes.Omega1.num=46", "axes.c.num=21")
MAP = ("axes.Omega1.num=100", "axes.c.num=100", "integrate.duration=10000", "stop_early=false")
SMALL_MAP = ("axes.Omega1.num=20", "axes.c.num=20")
WORKERS = 2
UNIT = "s per run; kernel: ns per step and cell"


@dataclass
class Run:
    """A sweep that is run in a fresh process each time it is called, each time into a new folder."""

    folder: Path
    changes: tuple[str, ...]
    workers: int = WORKERS
    times: int = field(default=0, init=False)

    def __call__(self) -> None:
        """Run it from scratch."""
        self.times += 1
        command = [sys.executable, "-m", "quavsweep", "run", str(OMEGA_C), "--no-plot", "--out", str(self.out)]
        command += ["--workers", str(self.workers)]
        for change in self.changes:
            command += ["--set", change]
        subprocess.run(command, check=True, capture_output=True)

    @property
    def out(self) -> Path:
        """Where the last run lies."""
        return self.folder / f"run{self.times}"

    @property
    def work(self) -> int:
        """Steps times cells."""
        sweep = load_sweep(OMEGA_C, self.changes)
        return sweep.grid.size * sweep.clock.steps

    def contender(self, name: str) -> Contender:
        """Return it as a contender whose samples are single runs, timed in seconds."""
        return Contender(name, self, 1e9, once=True)


@dataclass(frozen=True)
class Rounds:
    """Rounds of whole runs beside each other, and what two of the runs found."""

    samples: Samples
    work: int
    certified: int
    identical: bool


@cache
def omega_c_rounds(protocol: Protocol) -> Rounds:
    """Measure in turn: a step, the sweep to its end with two workers, a step, with one worker, and with early stops."""
    thumbnail = THUMBNAIL if protocol.quick else ()
    full = (*thumbnail, "stop_early=false")
    step = Printed(yaw_cells(), 3, 0.02, 25, 40).per_step
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        Run(root / "warm", (*THUMBNAIL, "integrate.duration=200", "integrate.transient=200"))()
        two, one, early = Run(root / "two", full), Run(root / "one", full, 1), Run(root / "early", thumbnail)
        samples = compare(
            [
                step("step before"),
                two.contender("2 workers"),
                step("step after"),
                one.contender("1 worker"),
                early.contender("stop early"),
            ],
            protocol,
        )
        return Rounds(samples, two.work, *_certified_alike(two.out, early.out))


def _certified_alike(full: Path, early: Path) -> tuple[int, bool]:
    """Return how many cells both runs certify as sinks, and whether they agree there in region and exponents."""
    a, b = open_result(full), open_result(early)
    both = np.isfinite(a["eigenvalue_re"]).all(axis=-1) & np.isfinite(b["eigenvalue_re"]).all(axis=-1)
    same = all(
        np.array_equal(a[name][both], b[name][both]) for name in ("region", "lyapunov", "equilibrium", "eigenvalue_re")
    )
    return int(both.sum()), same


def sweep_over_kernel(protocol: Protocol) -> Measurement:
    """Wall x workers of the whole sweep over cells x steps x time of a step with Gram-Schmidt every 25."""
    rounds = omega_c_rounds(protocol)
    before, after, wall = (rounds.samples[name] for name in ("step before", "step after", "2 workers"))
    values = [1e9 * w * WORKERS / rounds.work / (0.5 * (s + t)) for w, s, t in zip(wall, before, after, strict=True)]
    note = f"{np.median(wall):.1f} s with {WORKERS} workers, {rounds.work:.3g} steps x cells" + _thumbnail(protocol)
    return Measurement(values, rounds.samples, UNIT, note, comparable=not protocol.quick)


def two_over_one(protocol: Protocol) -> Measurement:
    """Wall with one worker over wall with two."""
    samples = omega_c_rounds(protocol).samples
    note = f"{np.median(samples['1 worker']):.1f} s and {np.median(samples['2 workers']):.1f} s" + _thumbnail(protocol)
    return Measurement(ratios(samples, "1 worker", "2 workers"), samples, UNIT, note, comparable=not protocol.quick)


def early_stops(protocol: Protocol) -> Measurement:
    """Wall without early stops over wall with them; whether the certified cells are the same."""
    rounds = omega_c_rounds(protocol)
    off, on = (float(np.median(rounds.samples[name])) for name in ("2 workers", "stop early"))
    note = f"{on:.1f} s against {off:.1f} s; {rounds.certified} cells certified in both, "
    note += ("identical" if rounds.identical else "NOT identical") + _thumbnail(protocol)
    detail = {"certified": rounds.certified, "identical": rounds.identical}
    return Measurement(ratios(rounds.samples, "2 workers", "stop early"), rounds.samples, UNIT, note, detail)


def cells_per_second(protocol: Protocol) -> Measurement:
    """Cells per second of a map of 100 x 100 cells, T = 1e4 after a transient of 1e3, three exponents."""
    with tempfile.TemporaryDirectory() as folder:
        run = Run(Path(folder), (*MAP, *(SMALL_MAP if protocol.quick else ())))
        Run(Path(folder) / "warm", (*MAP, *SMALL_MAP, "integrate.duration=1000"))()
        samples = compare([run.contender("map")], protocol)
    cells = load_sweep(OMEGA_C, run.changes).grid.size
    note = f"yaw system, dt 0.02, {cells} cells to the end, {WORKERS} workers" + _thumbnail(protocol)
    return Measurement([cells / seconds for seconds in samples["map"]], samples, "s per run", note)


def _thumbnail(protocol: Protocol) -> str:
    return "; a thumbnail, start-up counts" if protocol.quick else ""


ROWS = (
    Row("whole-sweep", "sweep", "whole sweep / kernel", "x", at_most(1.08), sweep_over_kernel),
    Row("workers", "sweep", "2 workers / 1", "x", at_least(1.9), two_over_one),
    Row("map", "sweep", "100 x 100 cells, T = 1e4", "/s", None, cells_per_second),
    Row("stop-early", "sweep", "omega_c, stop_early off / on", "x", None, early_stops),
)
