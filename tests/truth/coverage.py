"""Error bars that hold: runs from many starts on one attractor, each with its own error, against each other."""

from __future__ import annotations

import numpy as np

from quavsweep import Result, Sweep, parse_sweep
from quavsweep.codes import Region
from tests.truth.laboratory import Laboratory, described
from tests.truth.row import Claim, Row

RUNS = 200
SHARE = (0.90, 0.98)  # of runs whose 2 standard errors hold the mean
RATIO = (0.85, 1.25)  # mean standard error against the scatter
LORENZ = """
name: coverage-lorenz
model: lorenz
initial: {y: 1, z: 20}
axes: {x: {start: 1, stop: 20, num: 200}}
integrate: {method: rk4, dt: 0.01, transient: 200, duration: 12000}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
YAW = """
name: coverage-yaw
model: quadrotor_yaw
parameters: {Omega1: 240, c: 5}
initial: {q: 0.001, r: 0.001}
axes: {p: {start: 0.0005, stop: 0.05, num: 256}}
integrate: {method: rk4, dt: 0.02, transient: 1000, duration: 12000}
measures: {lyapunov: {exponents: 3, block: 25}}
"""


def lorenz(laboratory: Laboratory) -> list[Claim]:
    """Hold the errors of Lorenz' exponents against their scatter."""
    quick = ("integrate.duration=1000", "axes.x.num=64")
    return _claims(laboratory, parse_sweep(LORENZ, changes=laboratory.choose((), quick)))


def yaw(laboratory: Laboratory) -> list[Claim]:
    """Hold the errors of the yaw system's exponents against their scatter."""
    quick = ("integrate.duration=6000", "axes.p.num=64")
    return _claims(laboratory, parse_sweep(YAW, changes=laboratory.choose((), quick)))


def _claims(laboratory: Laboratory, sweep: Sweep) -> list[Claim]:
    result = laboratory.run(sweep.name, sweep)
    runs = np.flatnonzero(result["region"] == Region.CHAOS)[: laboratory.choose(RUNS, 64)]
    setting = f"{described(sweep)}; {runs.size} runs that are chaos at the end, of {result['region'].size}"
    wanted = laboratory.choose(RUNS, 32)
    enough = Claim(f"{wanted} runs that stay chaotic", f"{runs.size}", runs.size >= wanted, setting)
    return [enough, *_held(result, runs, setting)] if runs.size > 1 else [enough]


def _held(result: Result, runs: np.ndarray, setting: str) -> list[Claim]:
    value, error = result["lyapunov_raw"][runs], result["lyapunov_se"][runs]
    mean, scatter = value.mean(axis=0), value.std(axis=0, ddof=1)
    share = (np.abs(value - mean) <= 2 * error).mean(axis=0)
    ratio = error.mean(axis=0) / scatter
    neutral = float((np.abs(value[:, 1]) <= 3 * error[:, 1]).mean())
    claims = []
    for i, name in ((0, "first"), (2, "last")):
        numbers = {"mean": mean[i], "scatter": scatter[i], "mean_error": error[:, i].mean(), "share": share[i]}
        measured = f"{share[i]:.1%}; the mean is {mean[i]:.6f}, the scatter {scatter[i]:.2e}"
        asked = f"{name} exponent: the mean of all runs within 2 errors of a run in 90 to 98 %"
        claims.append(Claim(asked, measured, SHARE[0] <= share[i] <= SHARE[1], setting, numbers))
        asked = f"{name} exponent: mean error / scatter in 0.85 .. 1.25"
        claims.append(Claim(asked, f"{ratio[i]:.3f}", RATIO[0] <= ratio[i] <= RATIO[1], setting, {"ratio": ratio[i]}))
    measured = f"{neutral:.1%}; the mean is {mean[1]:.1e}, the mean error {error[:, 1].mean():.1e}, "
    measured += f"the scatter {scatter[1]:.1e}"
    numbers = {"share": neutral, "mean": mean[1], "scatter": scatter[1], "mean_error": error[:, 1].mean()}
    asked = "neutral exponent within 3 errors of zero in >= 95 %"
    return [*claims, Claim(asked, measured, neutral >= 0.95, setting, numbers)]


ROWS = (
    Row("coverage-lorenz", "error bars of Lorenz' exponents", "5 s", lorenz),
    Row("coverage-yaw", "error bars of the yaw system's exponents", "5 s", yaw),
)
