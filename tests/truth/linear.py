"""Linear systems: raw exponents are the real parts of the eigenvalues, but for the method's error and O(1/T)."""

from __future__ import annotations

import numpy as np

from quavsweep import parse_sweep
from tests.truth.laboratory import Laboratory, described
from tests.truth.row import Claim, Row

CONFIG = """
name: linear
model: linear
parameters: {im: 1}
initial: {x: 0, y: 0, z: 0}
axes:
  k: {values: [0, 3]}
  re: {start: -1, stop: 0.1, num: 12}
  a: {start: -1, stop: 0.1, num: 12}
integrate: {method: rk4, dt: 0.05, transient: 2000, duration: 20000}
measures: {lyapunov: {exponents: 3, block: 20}}
stop_early: false
"""
ROUNDING = 1e-11  # 1/time
HIGHER = 1.1  # the next order of the method's error is about |lambda| dt of this one
BOUNDED = 5.0  # growth of ln by which oblique eigenvectors may differ between two times


def eigenvalues(laboratory: Laboratory) -> list[Claim]:
    """Hold raw exponents against eigenvalues over a plane of them."""
    sweep = parse_sweep(CONFIG, changes=laboratory.choose((), ("integrate.duration=4000",)))
    result = laboratory.run(sweep.name, sweep)
    k, re, a = np.meshgrid(result["k"], result["re"], result["a"], indexing="ij")
    exact = -np.sort(-np.stack([re, re, a], axis=-1), axis=-1)
    size = np.maximum(np.hypot(re, 1.0), np.abs(a))
    method = HIGHER * size**5 * sweep.clock.dt**4 / 120
    miss = np.abs(result["lyapunov_raw"] - exact).max(axis=-1)
    setting = f"{described(sweep)}; eigenvalues re +- i, a"
    normal, oblique = k == 0, k != 0
    share = float((miss / (method + ROUNDING))[normal].max())
    claims = [
        Claim(
            "normal matrices: raw exponents are the real parts up to lambda^5 dt^4 / 120",
            f"{miss[normal].max():.2e} at most, {share:.3f} of that (and of {ROUNDING:g}, {HIGHER} for higher orders)",
            share <= 1.0,
            setting,
            {"worst": miss[normal].max(), "share": share},
        )
    ]
    rest = float((np.maximum(miss - method, 0.0) * sweep.clock.duration)[oblique].max())
    measured = f"{miss[oblique].max():.2e} at most; what lambda^5 dt^4 / 120 leaves is {rest:.2f} / T"
    asked = f"oblique eigenvectors: up to lambda^5 dt^4 / 120 and {BOUNDED:g} / T"
    numbers = {"worst": miss[oblique].max(), "bounded": rest}
    return [*claims, Claim(asked, measured, rest <= BOUNDED, setting, numbers)]


ROWS = (Row("published-linear", "linear systems against their eigenvalues", "3 s", eigenvalues),)
