"""Exponents that people outside this project have published, each within its error, by the 8th-order method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from quavsweep import Result, Sweep, parse_sweep
from quavsweep.codes import Region
from tests.truth.laboratory import Laboratory, described
from tests.truth.row import Claim, Row

SUMS = 1e-8  # wanted of raw sums less the mean divergence, 1/time
SIGMA = 3
SHORT = 2000.0  # duration that is enough to see that a row works


@dataclass(frozen=True)
class Case:
    """A published system.

    Parameters
    ----------
    key, title, cost : str
    source : str
    config : str
        YAML text; its one axis varies the start.
    exponents : tuple of (value, error)
        Errors as stated, else a unit of the last digit printed.
    region : Region
    total : float, optional
        Their sum, where it is the same at every state.
    dimension : (value, error), optional
        Kaplan and Yorke's.
    raw : bool
        Whether the raw exponents are judged, or those that certificates replaced.
    """

    key: str
    title: str
    cost: str
    source: str
    config: str
    exponents: tuple[tuple[float, float], ...]
    region: Region
    total: float | None = None
    dimension: tuple[float, float] | None = None
    raw: bool = True

    def row(self) -> Row:
        """Return it as a row of the table."""
        return Row(f"published-{self.key}", self.title, self.cost, self._measure())

    def _measure(self) -> Callable[[Laboratory], list[Claim]]:
        def measure(laboratory: Laboratory) -> list[Claim]:
            sweep = parse_sweep(self.config)
            if laboratory.quick:
                duration = min(sweep.clock.duration, SHORT)
                sweep = parse_sweep(self.config, changes=[f"integrate.duration={duration!r}"])
            return claims(self, sweep, laboratory.run(sweep.name, sweep))

        return measure


def claims(case: Case, sweep: Sweep, result: Result) -> list[Claim]:
    """Hold a result against what is published of it."""
    setting = f"{described(sweep)}; means over {sweep.grid.size} runs"
    region, name = result["region"], case.region.name.lower()
    share = float((region == case.region).mean())
    found = [Claim(f"region {name} from each start", f"{share:.1%}", share == 1.0, setting)]
    value, error = result["lyapunov_raw" if case.raw else "lyapunov"], result["lyapunov_se"]
    mean, se = value.mean(axis=0), np.sqrt((error**2).sum(axis=0)) / len(error)
    for i, (published, uncertain) in enumerate(case.exponents):
        own = np.maximum(uncertain, SIGMA * error[:, i])
        single = int((np.abs(value[:, i] - published) <= own).sum())
        asked = f"exponent {i + 1} is {published:g} +- {uncertain:g} or {SIGMA} errors ({case.source})"
        measured = f"{mean[i]:.7g} +- {se[i]:.1e}; {single} of {len(value)} single runs"
        numbers = {"mean": mean[i], "error": se[i], "single": single, "values": value[:, i], "errors": error[:, i]}
        holds = bool(abs(mean[i] - published) <= max(uncertain, SIGMA * se[i]))
        found.append(Claim(asked, measured, holds, setting, numbers))
    if case.raw:
        found.append(_sums(case, result, setting))
    if case.dimension is not None:
        found.append(_dimension(case.dimension, mean, se, setting))
    return found


def _sums(case: Case, result: Result, setting: str) -> Claim:
    """Hold raw sums against the mean divergence, and against its closed form where there is one."""
    sums = result["lyapunov_raw"].sum(axis=-1)
    known = case.total if case.total is not None else sums.mean()
    stored = result["sum_error"] if "sum_error" in result else np.full(sums.shape, np.nan)
    worst = np.abs(sums - known).max() if case.total is not None else np.abs(stored).max()
    measured = f"{worst:.1e} at most; the sum is {sums.mean():.9g}" if np.isfinite(worst) else "not available"
    form = f", {case.total:.9g}," if case.total is not None else ""
    asked = f"raw sums less the mean divergence{form} within {SUMS:g}"
    agree = case.total is None or not np.isfinite(stored).any() or float(np.abs(stored - (sums - known)).max()) < SUMS
    numbers = {"worst": worst, "stored": np.abs(stored).max(), "sum": sums.mean()}
    return Claim(asked, measured, bool(worst <= SUMS) and agree, setting, numbers)


def _dimension(published: tuple[float, float], mean: np.ndarray, se: np.ndarray, setting: str) -> Claim:
    value, uncertain = published
    measured = 2 + (mean[0] + mean[1]) / -mean[2]
    error = np.hypot(se[0], se[1]) / -mean[2]
    holds = bool(abs(measured - value) <= max(uncertain, SIGMA * error))
    asked = f"Kaplan and Yorke's dimension is {value:g} +- {uncertain:g} or {SIGMA} errors"
    numbers = {"dimension": measured, "error": error}
    return Claim(asked, f"{measured:.6f} +- {error:.1e}", holds, setting, numbers)


LORENZ = """
name: lorenz-classic
model: lorenz
initial: {y: 1, z: 20}
axes: {x: {start: 1, stop: 16, num: 16}}
integrate: {method: dp8, dt: 0.01, transient: 100, duration: 1.0e+6}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
WOLF = """
name: lorenz-wolf
model: lorenz
parameters: {sigma: 16, rho: 45.92, beta: 4}
initial: {y: 1, z: 20}
axes: {x: {start: 1, stop: 16, num: 16}}
integrate: {method: dp8, dt: 0.005, transient: 100, duration: 20000}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
SINK = """
name: lorenz-sink
model: lorenz
parameters: {rho: 20}
initial: {y: 1, z: 20}
axes: {x: {start: 1, stop: 16, num: 16}}
integrate: {method: rk4, dt: 0.01, transient: 200, duration: 2000}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
ROSSLER = """
name: rossler
model: rossler
parameters: {a: 0.2, b: 0.2, c: 5.7}
initial: {y: 1, z: 1}
axes: {x: {start: 0.5, stop: 2, num: 16}}
integrate: {method: dp8, dt: 0.02, transient: 1000, duration: 2.0e+5}
measures: {lyapunov: {exponents: 3, block: 20}}
"""
CHEN = """
name: chen
model: chen
parameters: {a: 35, b: 3, c: 28}
initial: {y: 1, z: 20}
axes: {x: {start: 1, stop: 16, num: 16}}
integrate: {method: dp8, dt: 0.0025, transient: 100, duration: 20000}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
JERK = """
name: jerk
model: jerk
parameters: {A: 2.017}
initial: {x: 0, w: 0}
axes: {v: {start: 0.47, stop: 0.5, num: 16}} # from 0.506 on it escapes
integrate: {method: dp8, dt: 0.05, transient: 1000, duration: 2.0e+5}
measures: {lyapunov: {exponents: 3, block: 20}}
"""
STUART_LANDAU = """
name: stuart_landau
model: stuart_landau
initial: {y: 0}
axes: {x: {start: 0.1, stop: 1.6, num: 16}}
integrate: {method: dp8, dt: 0.05, transient: 100, duration: 20000}
measures: {lyapunov: {exponents: 2, block: 20}}
stop_early: false
"""
TORUS = """
name: torus
model: torus
initial: {y: 0, psi: 0}
axes: {x: {start: 0.1, stop: 1.6, num: 16}}
integrate: {method: dp8, dt: 0.05, transient: 100, duration: 20000}
measures: {lyapunov: {exponents: 3, block: 20}}
"""
CLOSED = "closed form"
CHAOS = Region.CHAOS
CASES = (
    Case(
        *("lorenz", "Lorenz (10, 28, 8/3), T = 1e6 from each of 16 starts", "1 min", "Sprott", LORENZ),
        ((0.9056, 5e-4), (0.0, 1e-4), (-14.5723, 5e-4)),
        *(CHAOS, -41 / 3, (2.06215, 3e-5)),
    ),
    Case(
        *("wolf", "Lorenz (16, 45.92, 4)", "3 s", "Wolf et al. 1985", WOLF),
        ((1.50, 0.01), (0.0, 0.01), (-22.50, 0.01)),
        *(CHAOS, -21.0),
    ),
    Case(
        *("sink", "Lorenz' sink at rho 20", "2 s", "eigenvalues", SINK),
        ((-0.15479, 1e-5), (-0.15479, 1e-5), (-13.35708, 1e-5)),
        region=Region.SINK,
        raw=False,
    ),
    Case(
        *("rossler", "Rössler (0.2, 0.2, 5.7)", "10 s", "Sprott", ROSSLER),
        ((0.0714, 1e-4), (0.0, 1e-4), (-5.3943, 1e-4)),
        CHAOS,
        dimension=(2.0132, 1e-4),
    ),
    Case(
        *("chen", "Chen (35, 3, 28)", "10 s", "Lyapunov-spectrum collection", CHEN),
        ((2.024, 0.004), (0.0, 0.001), (-12.024, 0.004)),
        *(CHAOS, -10.0),
    ),
    Case(
        *("jerk", "the jerk system at A = 2.017", "5 s", "Sprott 1997", JERK),
        ((0.0551, 1e-4), (0.0, 1e-4), (-2.0721, 1e-4)),
        *(CHAOS, -2.017),
    ),
    Case(
        *("stuart-landau", "the Stuart-Landau oscillator, raw", "2 s", CLOSED, STUART_LANDAU),
        ((0.0, 1e-6), (-2.0, 1e-6)),
        region=Region.PERIODIC,
    ),
    Case(
        *("torus", "a torus with an angle on a circle", "3 s", CLOSED, TORUS),
        ((0.0, 1e-6), (0.0, 1e-6), (-2.0, 1e-6)),
        region=Region.QUASI_PERIODIC,
    ),
)
ROWS = tuple(case.row() for case in CASES)
