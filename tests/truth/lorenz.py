"""Lorenz' system from rho 0.5 to 350: its regimes, and how long its transient chaos lasts."""

from __future__ import annotations

import numpy as np

from quavsweep import parse_sweep
from quavsweep.codes import REGION, Region
from tests.truth.laboratory import Laboratory, described
from tests.truth.row import Claim, Row

REGIMES = """
name: lorenz-regimes
model: lorenz
initial: {x: 1, y: 1, z: 20}
axes: {rho: {values: [0.5, 10, 20, 28, 100.5, 160, 350]}}
integrate: {method: rk4, dt: 0.002, transient: 200, duration: 800}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
LIFETIMES = """
name: lorenz-lifetimes
model: lorenz
axes:
  rho: {values: [22, 23, 23.5]}
  ensemble: {num: 1024, seed: 1, box: {x: [-20, 20], y: [-20, 20], z: [5, 45]}}
integrate: {method: rk4, dt: 0.01, duration: 20000, segment: 10}
measures: {last_time: {of: x, at: 0}}
"""
SIDE_BY_SIDE = """
name: lorenz-side-by-side
model: lorenz
axes:
  rho: {values: [24, 24.4]}
  ensemble: {num: 256, seed: 1, box: {x: [-20, 20], y: [-20, 20], z: [5, 45]}}
integrate: {method: rk4, dt: 0.01, duration: 20000, segment: 200}
"""
EXPECTED = (Region.SINK, Region.SINK, Region.SINK, Region.CHAOS, *[Region.PERIODIC] * 3)
LAST_CHANGE = (28.0, 230.0, 1700.0)  # mean time over all starts
WITHIN = 0.15
HARDLY = 0.2


def regimes(laboratory: Laboratory) -> list[Claim]:
    """Say how the orbit ends at each rho."""
    sweep = parse_sweep(REGIMES)
    result = laboratory.run(sweep.name, sweep)
    setting, claims = described(sweep), []
    for i, (rho, expected) in enumerate(zip(result["rho"], EXPECTED, strict=True)):
        region, point = REGION[result["region"][i]].name, result["equilibrium"][i]
        exponents = ", ".join(f"{value:.5g}" for value in result["lyapunov"][i])
        holds, asked, measured = result["region"][i] == expected, expected.name.lower(), f"{region}; {exponents}"
        if expected == Region.SINK:
            side = np.sqrt(8 / 3 * max(rho - 1, 0.0))
            exact = np.array([side, side, max(rho - 1, 0.0)])
            miss = np.abs(np.abs(point) - exact).max()
            holds = holds and miss <= 1e-9
            asked += f" at +-({side:.4g}, {side:.4g}), {exact[2]:g}" if side else " at the origin"
            measured += f"; off by {miss:.1e}"
        elif "period" in result and np.isfinite(result["period"][i]):
            measured += f"; period {result['period'][i]:.9g}, {result['cycle_hits'][i]} hits"
        numbers = {"region": region, "exponents": result["lyapunov"][i], "equilibrium": point}
        claims.append(Claim(f"rho {rho:g}: {asked}", measured, bool(holds), setting, numbers))
    return claims


def lifetimes(laboratory: Laboratory) -> list[Claim]:
    """Hold the mean time of the last change of lobe against another computation, the engine's lifetime beside it."""
    quick = ("axes.ensemble.num=64", "integrate.duration=2000")
    sweep = parse_sweep(LIFETIMES, changes=laboratory.choose((), quick))
    result = laboratory.run(sweep.name, sweep)
    setting, claims = described(sweep), []
    for i, (rho, expected) in enumerate(zip(result["rho"], LAST_CHANGE, strict=True)):
        last = np.nan_to_num(result["last_time"][i])  # a start that never changes lobe changed it last at 0
        open_ = int((result["region"][i] != Region.SINK).sum())
        mean, error = last.mean(), last.std(ddof=1) / np.sqrt(last.size)
        own, own_error = result["lifetime"][i], result["lifetime_se"][i]
        share, after = result["chaotic_share"][i], result["lifetime_after"][i]
        measured = f"{mean:.4g} +- {error:.2g} ({last.size} starts, {open_} no sink yet); the engine's lifetime is "
        measured += f"{own:.4g} +- {own_error:.2g} of the share {share:.3f} that is chaotic beyond {after:.4g}"
        asked = f"rho {rho:g}: the mean time of the last hit of x = 0 is {expected:g} within 15 %"
        numbers = {"mean": mean, "error": error, "lifetime": own, "lifetime_se": own_error, "chaotic_share": share}
        holds = bool(abs(mean - expected) <= WITHIN * expected)
        claims.append(Claim(asked, measured, holds, setting, {**numbers, "lifetime_after": after}))
    return claims


def side_by_side(laboratory: Laboratory) -> list[Claim]:
    """Count chaos and sinks where transient chaos becomes lasting, at rho 24.06."""
    quick = ("axes.ensemble.num=32", "integrate.duration=2000")
    sweep = parse_sweep(SIDE_BY_SIDE, changes=laboratory.choose((), quick))
    result = laboratory.run(sweep.name, sweep)
    setting, claims = described(sweep), []
    for i, rho in enumerate(result["rho"]):
        region, settle = result["region"][i], result["settle_time"][i]
        sinks, chaos = (int((region == kind).sum()) for kind in (Region.SINK, Region.CHAOS))
        late = int((settle > 0.1 * sweep.clock.duration).sum())
        measured = f"{chaos} chaos, {sinks} sinks, {region.size - chaos - sinks} others; "
        measured += f"{late} of the sinks settled in the last nine tenths of the time"
        numbers = {"chaos": chaos, "sinks": sinks, "late": late}
        lasting = rho > 24.06
        asked = f"rho {rho:g}: " + ("chaos and sinks side by side" if lasting else "hardly any end is seen")
        holds = chaos > 0 and sinks > 0 if lasting else late <= HARDLY * (chaos + late)
        claims.append(Claim(asked, measured, holds, setting, numbers))
    return claims


ROWS = (
    Row("lorenz-regimes", "Lorenz from rho 0.5 to 350", "3 s", regimes),
    Row("lorenz-lifetimes", "transient chaos at rho 22, 23, 23.5", "1 min", lifetimes),
    Row("lorenz-side-by-side", "chaos and sinks at rho 24 and 24.4", "20 s", side_by_side),
)
