"""Evidence to regions: pure NumPy on what is stored, so thresholds can change without a new integration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from quavsweep.analysis.exact import exact_exponents
from quavsweep.classify.chaotic_phase import REGULAR, ChaoticPhase, chaotic_phase
from quavsweep.classify.convergence import convergence
from quavsweep.classify.growth import Average, Growth, growth_of
from quavsweep.classify.region import birkhoff_digits, region_of
from quavsweep.classify.self_check import missing_sum, missing_zero, sum_error, zero_error
from quavsweep.classify.variable import result_variables
from quavsweep.classify.window import Window, averaged, ends
from quavsweep.codes import Region
from quavsweep.config import Sweep
from quavsweep.measures import Evidence

__all__ = ["classify", "convergence", "missing_sum", "missing_zero", "regions", "result_variables", "unsettled"]

AT_ONCE = 2048  # cells, so that what is computed on the way stays small; fewer take longer, one by one

_AS_STORED = (
    *("status", "equilibrium", "eigenvalue_re", "eigenvalue_im"),
    *("period", "cycle_hits", "cycle_symmetry", "cycle_point", "multiplier_re", "multiplier_im"),
)


def classify(sweep: Sweep, evidence: Evidence) -> dict[str, np.ndarray]:
    """Return region, exponents and times of the cells of some evidence.

    Parameters
    ----------
    sweep : Sweep
        For its clock and thresholds.
    evidence : dict of (n, ...) arrays
        It may hold more batches than a cell was integrated for; `steps` tells how many count.

    Returns
    -------
    dict of (n, ...) arrays, one per variable of `result_variables`.
    """
    n = len(evidence["status"])
    result = {v.name: np.empty(v.shape(n, sweep.extents), v.dtype) for v in result_variables(sweep)}
    for cells, part in _parts(evidence):
        values = _described(sweep, part)
        for name, array in result.items():
            array[cells] = values[name]
    return result


def regions(sweep: Sweep, evidence: Evidence) -> np.ndarray:
    """Return only the region of each cell, (n,) int8; it costs a fraction of the rest."""
    found = [region_of(sweep, part, _growth(sweep, part)) for _, part in _parts(evidence)]
    return np.concatenate([np.zeros(0, np.int8), *found])


def unsettled(sweep: Sweep, evidence: Evidence) -> np.ndarray:
    """Return which cells are in a region of which the effort is, (n,) bool: those that more time may settle."""
    effort = sweep.config.effort
    return np.isin(regions(sweep, evidence), [Region[name.upper()] for name in (effort.of if effort else ())])


def _parts(evidence: Evidence) -> Iterator[tuple[slice, Evidence]]:
    """Yield a few cells at a time, and which they are."""
    for first in range(0, len(evidence["status"]), AT_ONCE):
        cells = slice(first, first + AT_ONCE)
        yield cells, {name: values[cells] for name, values in evidence.items()}


def _growth(sweep: Sweep, evidence: Evidence) -> Growth | None:
    return growth_of(evidence, sweep.clock) if sweep.measures.lyapunov else None


def _described(sweep: Sweep, evidence: Evidence) -> dict[str, np.ndarray]:
    """Return everything that is known of cells."""
    growth = _growth(sweep, evidence)
    region = region_of(sweep, evidence, growth)
    dt = sweep.clock.dt
    result = {
        "region": region,
        "time_used": evidence["steps"] * dt,
        "settle_time": np.where(ends(evidence), evidence["settled_steps"] * dt, np.nan),
        "final_state": evidence["state"],
        **{name: evidence[name] for name in _AS_STORED},
        **{variable.name: evidence[variable.name] for variable in sweep.measures.outputs},
    }
    return result if growth is None else result | _exponents(sweep, evidence, growth, region)


def _exponents(sweep: Sweep, evidence: Evidence, growth: Growth, region: np.ndarray) -> dict[str, np.ndarray]:
    """Return averaged and exact exponents with errors, the chaotic phase, and the self-checks."""
    window = averaged(evidence, sweep.clock)
    certified = ends(evidence)[:, None]
    raw, exact = growth.over(window, wanted=~certified[:, 0]), exact_exponents(evidence)
    phase, chaos = chaotic_phase(sweep, evidence, growth, region, exact), region == Region.CHAOS
    was = phase.found | chaos
    until = np.where(chaos, window[1], phase.until) * growth.batch
    alike = _unmixed(growth, raw, window, phase, np.isin(region, REGULAR) & ~certified[:, 0])
    return {
        "lyapunov": np.where(certified, exact[:, : raw.rate.shape[1]], alike.rate),
        "lyapunov_raw": raw.rate,
        "lyapunov_se": np.where(certified, 0.0, alike.error),
        "growth_departure": alike.departure,
        "birkhoff_digits": birkhoff_digits(growth, window),
        "was_chaotic": was,
        "chaotic_until": np.where(was, until, np.nan),
        "lyapunov_chaotic": np.where(chaos, raw.rate[:, 0], np.where(was, phase.rate, np.nan)),
        "lyapunov_chaotic_se": np.where(chaos, raw.error[:, 0], np.where(was, phase.error, np.nan)),
        "sum_error": sum_error(sweep, evidence, raw, window),
        "zero_error": zero_error(sweep, evidence, region, alike, exact),
    }


def _unmixed(growth: Growth, raw: Average, window: Window, phase: ChaoticPhase, regular: np.ndarray) -> Average:
    """Return the averages of a window, but of regular orbits only of what comes behind their chaotic phase.

    They begin a batch later than it ends, because it may end within a batch.
    """
    first, last = np.maximum(window[0], phase.until + 1), window[1]
    cells = np.flatnonzero(regular & phase.found & (first < last))
    behind = growth.of(cells).over((first[cells], last[cells]))
    alike = Average(*(getattr(raw, field.name).copy() for field in fields(Average)))
    for field in fields(Average):
        getattr(alike, field.name)[cells] = getattr(behind, field.name)
    return alike
