"""Lifetimes of the yaw system's transient chaos at c = 5, with another seed, and a twin by SciPy alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from quavsweep import Sweep, parse_sweep
from tests.truth.laboratory import Laboratory, changed, described
from tests.truth.row import Claim, Row
from tests.truth.shooting import Rhs, field

CONFIG = """
name: lifetimes
model: quadrotor_yaw
parameters: {c: 5}
axes:
  Omega1: {values: [160, 180, 196.4, 220]}
  ensemble: {num: 1024, seed: 1, box: {p: [-2, 2], q: [-2, 2], r: [-4, 6]}}
integrate: {method: rk4, dt: 0.02, duration: 20000, segment: 50}
"""
CHOSEN = 196.4
BOX = ((-2.0, 2.0), (-2.0, 2.0), (-4.0, 6.0))
SIDE = (0.6025, 1.4159, 0.4443)  # equilibrium at 196.4, as the paper prints it
NEAR = 0.05  # rad/s from a side equilibrium: the orbit spirals in
TWINS = 256
ERRORS = 3


def lifetimes(laboratory: Laboratory) -> list[Claim]:
    """State lifetimes, and hold one against another seed and a twin."""
    quick = ("axes.ensemble.num=48", "integrate.duration=3000")
    sweep = parse_sweep(CONFIG, changes=laboratory.choose((), quick))
    result = laboratory.run(sweep.name, sweep)
    other = changed(sweep, "axes.ensemble.seed=2", f"axes.Omega1.values=[{CHOSEN}]")
    again = laboratory.run("lifetimes-seed", other)
    claims, setting = [], described(sweep)
    names = ("lifetime", "lifetime_se", "chaotic_share", "chaotic_share_se", "lifetime_after")
    for i, omega in enumerate(result["Omega1"]):
        mean, error, share, share_error, after = (float(result[name][i]) for name in names)
        measured = f"{mean:.5g} +- {error:.2g} s from t = 0, of the share {share:.3f} +- {share_error:.3f} that is "
        measured += f"chaotic beyond {after:g} s"
        if "lifetime_p" in result:
            measured += f"; probability of such a departure from an exponential {float(result['lifetime_p'][i]):.2f}"
        known = bool(np.isfinite([mean, error, share]).all())
        numbers = {name: float(result[name][i]) for name in names}
        claims.append(Claim(f"Omega1 = {omega:g}: mean, share, error", measured, known, setting, numbers))
    i = int(np.argmin(np.abs(result["Omega1"] - CHOSEN)))
    own = float(result["lifetime"][i]), float(result["lifetime_se"][i])
    seed = float(again["lifetime"][0]), float(again["lifetime_se"][0])
    claims.append(_agree("another seed", own, seed, described(other)))
    twin = twin_lifetime(laboratory, sweep, float(result["lifetime_after"][i]))
    return [*claims, _agree("SciPy's DOP853 alone", own, twin[:2], twin[2])]


def _agree(name: str, a: tuple[float, float], b: tuple[float, float], setting: str) -> Claim:
    apart = abs(a[0] - b[0]) / np.hypot(a[1], b[1])
    asked = f"Omega1 = {CHOSEN:g}: {name} agrees within {ERRORS} errors"
    measured = f"{b[0]:.5g} +- {b[1]:.2g} s against {a[0]:.5g} +- {a[1]:.2g} s, {apart:.2f} errors apart"
    return Claim(asked, measured, bool(apart <= ERRORS), setting, {"lifetime": b[0], "lifetime_se": b[1]})


def twin_lifetime(laboratory: Laboratory, sweep: Sweep, after: float) -> tuple[float, float, str]:
    """Return the mean lifetime of starts that are chaotic beyond a time, its error, and how it was made.

    A start has left at the last look at which it was farther than `NEAR` from both side equilibria; the mean residual
    time of exponential leaving, with starts that stay, is the sum of the times beyond over the number that left.
    """
    segment, end = sweep.clock.segment_steps * sweep.clock.dt, sweep.clock.segments
    model = sweep.model
    p = [sweep.parameters.get(name, CHOSEN) for name in model.parameter_names]
    root = fsolve(lambda u: field(model.rhs, u, p), SIDE, xtol=1e-12)
    sides = np.stack([root, root * (-1, -1, 1)])
    low, high = np.array(BOX).T
    u = np.random.default_rng(256).uniform(low, high, (laboratory.choose(TWINS, 32), 3)).T
    stayed = np.zeros(u.shape[1])
    going = np.arange(u.shape[1])
    for look in range(1, end + 1):
        u[:, going] = _advanced(model.rhs, u[:, going], segment, p)
        away = np.linalg.norm(u[:, going].T[:, None] - sides, axis=2).min(axis=1)
        stayed[going[away > NEAR]] = look * segment
        going = going[away > NEAR / 50]  # beyond that nothing comes back
        if not going.size:
            break
    left = stayed < end * segment
    beyond = stayed >= after
    count = int((beyond & left).sum())
    mean = float((stayed[beyond] - after).sum() / max(count, 1))
    setting = f"{stayed.size} starts of its own, DOP853 rtol 1e-8, looks every {segment:g} s to {end * segment:g}; "
    setting += f"{count} of {int(beyond.sum())} that stay beyond {after:g} s leave"
    return after + mean, mean / np.sqrt(max(count, 1)), setting


def _advanced(rhs: Rhs, u: np.ndarray, time: float, p: Sequence[float]) -> np.ndarray:
    """Return states (3, n) after some time."""

    def derivative(_: float, flat: np.ndarray) -> np.ndarray:
        return field(rhs, flat.reshape(u.shape), p).ravel()

    done = solve_ivp(derivative, (0.0, time), u.ravel(), "DOP853", [time], rtol=1e-8, atol=1e-10)
    return np.asarray(done.y[:, -1]).reshape(u.shape)


ROWS = (Row("lifetimes", "transient chaos in yaw at c = 5", "2 min", lifetimes),)
