"""Shorter and longer runs: `--horizon` and `extend` say what a run of that length would have said."""

from __future__ import annotations

import numpy as np

from quavsweep import Sweep, extend_sweep, load_sweep, open_result, run_sweep
from tests.truth.comparison import differences, words
from tests.truth.laboratory import Laboratory, described
from tests.truth.plane import plane
from tests.truth.row import Claim, Row

SHAPE = (46, 21)
SEED = 7
TIMES = 3
STATE = "final_state"  # not stored of cells that went on beyond the horizon


def horizons(laboratory: Laboratory) -> list[Claim]:
    """Hold a run at three random horizons against real runs of that length."""
    sweep = plane("omega_c", laboratory.choose(SHAPE, (13, 7)))
    laboratory.run("horizon", sweep)
    clock = sweep.clock
    segments = np.arange(clock.transient_segments + 1, clock.segments)
    chosen = np.sort(np.random.default_rng(SEED).choice(segments, TIMES, replace=False))
    claims = []
    for segment in chosen:
        steps = int(segment) * clock.segment_steps
        seen = open_result(laboratory.path("horizon"), horizon=steps * clock.dt)
        real = laboratory.run(f"horizon-{segment}", shorter(laboratory, clock.dt * (steps - clock.transient_steps)))
        others = [name for name in seen.variables if name != STATE]
        ended = np.isfinite(seen[STATE]).all(axis=-1).ravel()
        differ = differences(seen, real, others) | differences(seen, real, [STATE], ended)
        asked = f"--horizon {steps * clock.dt:g} is a run of that length in each of {len(seen.variables)} variables"
        numbers = {"horizon": steps * clock.dt, "differ": differ, "variables": seen.variables}
        measured = f"{words(differ) or 'all equal'}; {STATE} known in {ended.sum()} of {ended.size} cells"
        claims.append(Claim(asked, measured, not differ and len(others) > 5, described(sweep), numbers))
    return claims


def shorter(laboratory: Laboratory, duration: float) -> Sweep:
    """Return the sweep of the run with another duration, the same batches and segments."""
    return load_sweep(laboratory.path("horizon") / "config.yaml", [f"integrate.duration={duration!r}"])


def extended(laboratory: Laboratory) -> list[Claim]:
    """Hold a run that was taken on against one that was as long from the start."""
    sweep = plane("omega_c", laboratory.choose(SHAPE, (13, 7)))
    laboratory.run("horizon", sweep)
    half = shorter(laboratory, sweep.clock.segment_steps * sweep.clock.dt * (sweep.clock.segments // 2))
    whole = laboratory.path("horizon") / "result.h5"
    path = run_sweep(half, laboratory.path("extended"), workers=laboratory.workers, longer=True)
    first = open_result(path).sweep.clock.duration
    path = extend_sweep(laboratory.path("extended"), sweep.clock.duration, workers=laboratory.workers)
    equal = path.read_bytes() == whole.read_bytes()
    measured = f"{path.stat().st_size} bytes, {'equal' if equal else 'NOT equal'}"
    asked = f"extend from T = {first:g} to {sweep.clock.duration:g} equals the long run to the byte"
    return [Claim(asked, measured, equal, described(sweep), {"bytes": path.stat().st_size})]


ROWS = (
    Row("horizon", "what a shorter run would have said", "10 s", horizons),
    Row("extend", "runs taken on", "5 s", extended),
)
