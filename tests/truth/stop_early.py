"""Early ends change nothing that is said of certified cells, and save time."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import numpy as np

from quavsweep import Result, Sweep, open_result, run_sweep
from quavsweep.codes import Status
from tests.truth.comparison import differences, words
from tests.truth.laboratory import Laboratory, described
from tests.truth.plane import plane
from tests.truth.row import Claim, Row

ROUNDS = 2
# What tells how, when and in which state the integration ended, and averages up to then.
OF_THE_END = frozenset(
    [
        *("status", "time_used", "final_state", "lyapunov_raw", "growth_departure", "birkhoff_digits"),
        *("sum_error",),
    ]
)


def stop_early(laboratory: Laboratory) -> list[Claim]:
    """Run the plane in turn with and without early ends, each time from scratch."""
    shape = laboratory.choose(None, (23, 11))
    sweeps = {"on": plane("omega_c", shape), "off": plane("omega_c", shape, "stop_early=false")}
    run_sweep(plane("omega_c", (9, 5)), _anew(laboratory, "warm"), workers=laboratory.workers)
    seconds: dict[str, list[float]] = {name: [] for name in sweeps}
    for _ in range(laboratory.choose(ROUNDS, 1)):
        for name, sweep in sweeps.items():
            folder = _anew(laboratory, name)
            begin = time.perf_counter()
            run_sweep(sweep, folder, workers=laboratory.workers)
            seconds[name].append(time.perf_counter() - begin)
    results = {name: open_result(laboratory.path(f"stop-early-{name}")) for name in sweeps}
    return _claims(sweeps["on"], results["on"], results["off"], seconds)


def _anew(laboratory: Laboratory, name: str) -> Path:
    """Return the folder of a run with nothing in it."""
    folder = laboratory.path(f"stop-early-{name}")
    shutil.rmtree(folder, ignore_errors=True)
    return folder


def _claims(sweep: Sweep, on: Result, off: Result, seconds: dict[str, list[float]]) -> list[Claim]:
    ended = np.isin(on["status"], (Status.ENDED_SINK, Status.ENDED_CYCLE)).ravel()
    names = [name for name in on.variables if name not in OF_THE_END]
    differ = differences(on, off, names, ended)
    sinks = int((on["status"] == Status.ENDED_SINK).sum())
    told = f"differ: {words(differ)}" if differ else f"all of {', '.join(names)}"
    measured = f"{ended.sum()} certified cells ({sinks} sinks): {told}"
    numbers = {"certified": ended.sum(), "sinks": sinks, "differ": differ, "variables": names}
    asked = "certified cells are those of the run without early ends"
    same = Claim(asked, measured, not differ and bool(ended.any()), described(sweep), numbers)
    gain = [a / b for a, b in zip(seconds["off"], seconds["on"], strict=True)]
    wall = {name: ", ".join(f"{s:.1f}" for s in values) for name, values in seconds.items()}
    used = float(off["time_used"].sum() / on["time_used"].sum())
    measured = f"{np.median(gain):.2f} x (off {wall['off']} s, on {wall['on']} s); steps {used:.2f} x"
    numbers = {"seconds": seconds, "gain": gain, "steps": used}
    return [same, Claim("the gain in wall time, in turn", measured, None, described(sweep), numbers)]


ROWS = (Row("stop-early", "early ends on the whole plane omega_c", "6 min", stop_early),)
