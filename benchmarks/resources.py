"""The suite `resources`: start-up, memory, growth, and what a tile costs outside its kernel."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.protocol import Protocol
from benchmarks.row import Measurement, Row, at_most
from benchmarks.sweep import OMEGA_C
from quavsweep import load_sweep
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.kernels.compiler import default_lanes
from quavsweep.plan import Plan, make_plan
from quavsweep.tiling import choose_tile_cells, spread

# The same number of batches as the full run has, so the same evidence, in little time.
SHORT = ("integrate.transient=8", "integrate.duration=24", "integrate.dt=0.02", "measures.lyapunov.block=25")
RUN = ("-m", "quavsweep", "run", str(OMEGA_C), "--out")
_FIRST_TILE = """
import os, sys, time
import quavsweep.sweep as sweep
sweep.integrate_tile = lambda *_: (os.write(1, f"{time.time():.6f}\\n".encode()), os._exit(0))
sys.argv[0] = "quavsweep"
from quavsweep.cli import main
main()
"""
_PEAK = """
import resource, subprocess, sys
done = subprocess.run([sys.executable, *sys.argv[1:]], capture_output=True)
print(done.returncode, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024)
"""


def first_tile(warm: bool, protocol: Protocol) -> Measurement:
    """Time from the start of the process to the first tile [s], with or without anything in the cache."""
    seconds: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(protocol.samples + warm):
            cache_folder = Path(folder) / ("cache" if warm else f"cache{number}")
            out = Path(folder) / f"run{number}"
            began = time.time()
            words = [sys.executable, "-c", _FIRST_TILE, "run", str(OMEGA_C), "--out", str(out), "--no-plot"]
            said = _said(words, {"QUAVSWEEP_CACHE": str(cache_folder)})
            seconds.append(float(said.split()[0]) - began)
    return Measurement(seconds[warm:], {"first tile": seconds[warm:]}, "s", "omega_c, three exponents")


def outside_kernel(stop_early: bool, protocol: Protocol) -> Measurement:
    """Time of a tile of omega_c outside its kernel over the time in it [%].

    What the kernel returned is stored and played back, so that a tile can be timed without it.
    """
    sweep = load_sweep(OMEGA_C, [f"stop_early={str(stop_early).lower()}"])
    plan = make_plan(sweep, default_lanes())
    cells = choose_tile_cells(plan)
    starts = range(0, sweep.grid.size, cells)
    tiles = spread(Tile(i, start, min(start + cells, sweep.grid.size)) for i, start in enumerate(starts))
    outside, inside = [], []
    for tile in tiles[1 : 1 + protocol.samples]:
        whole, states = _recorded(plan, tile)
        played = _timed(plan, tile, _player(states))
        copied = _copying(states)
        outside.append(played - copied)
        inside.append(whole - (played - copied))
    values = [100 * o / i for o, i in zip(outside, inside, strict=True)]
    note = f"{cells} cells a tile, {np.median(inside):.2f} s in the kernel; stop_early {'on' if stop_early else 'off'}"
    return Measurement(values, {"outside": outside, "kernel": inside}, "s per tile", note)


def _recorded(plan: Plan, tile: Tile) -> tuple[float, list[np.ndarray]]:
    """Return the processor time of a tile [s], and the lanes after each call of its kernel."""
    whole = _timed(plan, tile, plan.advance)
    states: list[np.ndarray] = []

    def record(lanes: np.ndarray, *arguments: int) -> None:
        plan.advance(lanes, *arguments)
        states.append(lanes.copy())

    _timed(plan, tile, record)
    return whole, states


def _player(states: list[np.ndarray]) -> Callable[..., None]:
    """Return a kernel that returns what was recorded."""
    left = iter(states)

    def play(lanes: np.ndarray, *_: int) -> None:
        lanes[:] = next(left)

    return play


def _copying(states: list[np.ndarray]) -> float:
    """Return the time that copying what was recorded takes [s]."""
    lanes = np.empty_like(states[0])
    began = time.thread_time()
    for state in states:
        lanes[: state.size] = state
    return time.thread_time() - began


def _timed(plan: Plan, tile: Tile, advance: Callable[..., None]) -> float:
    began = time.thread_time()
    integrate_tile(replace(plan, advance=advance), tile, lambda: False)
    return time.thread_time() - began


@cache
def growth_runs(quick: bool) -> dict[int, tuple[float, float, int]]:
    """Return wall time [s], peak memory [bytes] and bytes on disk of runs of a thousand to a million cells."""
    found = {}
    shapes = ((50, 20), (100, 100), (400, 250), (1000, 1000))
    with tempfile.TemporaryDirectory() as folder:
        for shape in shapes[: 3 if quick else 4]:
            out = Path(folder) / "run"
            grid = [f"axes.{name}.num={n}" for name, n in zip(("Omega1", "c"), shape, strict=True)]
            words = [*RUN, str(out), *(word for change in (*SHORT, *grid) for word in ("--set", change))]
            began = time.perf_counter()
            code, peak = _said([sys.executable, "-c", _PEAK, *words]).split()
            if code != "0":
                raise RuntimeError(f"the run of {shape} cells ended with exit code {code}")
            seconds = time.perf_counter() - began
            size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
            found[shape[0] * shape[1]] = seconds, float(peak), size
            subprocess.run(["rm", "-r", str(out)], check=True)
    return found


def memory(protocol: Protocol) -> Measurement:
    """Peak memory of run, consolidation and plot beyond 100 bytes per cell, the largest over all sizes [MB]."""
    runs = growth_runs(protocol.quick)
    beyond = {cells: (peak - 100 * cells) / 1e6 for cells, (_, peak, _) in runs.items()}
    note = "; ".join(f"{cells} cells: {peak / 1e6:.0f} MB" for cells, (_, peak, _) in runs.items())
    return Measurement([max(beyond.values())], {"peak": [peak for _, peak, _ in runs.values()]}, "bytes", note)


def growth(protocol: Protocol) -> Measurement:
    """Time per further cell, between the two largest sizes, over that between the two before."""
    runs = growth_runs(protocol.quick)
    sizes = sorted(runs)
    slopes = [(runs[b][0] - runs[a][0]) / (b - a) for a, b in pairwise(sizes)]
    note = "; ".join(f"{cells} cells: {runs[cells][0]:.1f} s" for cells in sizes)
    note += f"; shards and result of {sizes[-1]}: {runs[sizes[-1]][2] / 1e9:.2f} GB, full evidence of 64 batches"
    samples = {"wall": [runs[cells][0] for cells in sizes]}
    return Measurement([slopes[-1] / slopes[-2]], samples, "s", note, {"runs": json.loads(json.dumps(runs))})


def _said(words: Sequence[str], environment: dict[str, str] | None = None) -> str:
    """Return what a command prints."""
    done = subprocess.run(words, check=True, capture_output=True, text=True, env={**os.environ, **(environment or {})})
    return done.stdout


ROWS = (
    Row("start-cold", "resources", "first tile, empty cache", "s", at_most(5), partial(first_tile, False)),
    Row("start-warm", "resources", "first tile, warm cache", "s", at_most(1.5), partial(first_tile, True)),
    Row("tile", "resources", "tile outside the kernel", "%", at_most(2), partial(outside_kernel, False)),
    Row("tile-early", "resources", "the same, stop_early", "%", at_most(2), partial(outside_kernel, True)),
    Row("memory", "resources", "peak memory - 100 B/cell", "MB", at_most(400), memory),
    Row("time-per-cell", "resources", "time per cell, 1e6 / 1e5", "x", None, growth),
)
