"""What a result holds in a few numbers: cells per region, how many were chaotic, the worst self-checks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from quavsweep.classify import missing_sum, missing_zero
from quavsweep.codes import REGION, Region
from quavsweep.config import Sweep
from quavsweep.result import Result
from quavsweep.store import block_cells, code_blocks, code_counts


@dataclass(frozen=True)
class Check:
    """The worst value of a self-check over all cells [1/time], or why there is none."""

    worst: float | None
    missing: str = ""


@dataclass(frozen=True)
class Summary:
    """A result in a few numbers.

    Parameters
    ----------
    cells : int
        In all.
    regions : dict
        From a region's name to its number of cells; only those that occur, `none` for cells not computed.
    was_chaotic : int, optional
        Cells that were chaotic at some time and are not in the end; None where nothing tells.
    sum_error : Check
        Largest distance of the sum of all exponents, as averaged, from the mean divergence.
    zero_error : Check
        Largest size of the exponent that must be zero away from equilibria.
    """

    cells: int
    regions: dict[str, int]
    was_chaotic: int | None
    sum_error: Check
    zero_error: Check


def summarise(result: Result) -> Summary:
    """Return a result in a few numbers."""
    count = code_counts(result.stored, "region", REGION)
    regions = {code.name: int(n) for code, n in zip(REGION, count, strict=True) if n}
    on_the_way = None
    if "was_chaotic" in result:
        pairs = code_blocks(result.stored, "region", "was_chaotic")
        on_the_way = sum(int(((was != 0) & (region != Region.CHAOS)).sum()) for region, was in pairs)
    checks = _worst(result, "sum_error", missing_sum), _worst(result, "zero_error", missing_zero)
    return Summary(int(count.sum()), regions, on_the_way, *checks)


def _worst(result: Result, name: str, missing: Callable[[Sweep], str]) -> Check:
    """Return the largest size of a self-check over all cells, read block by block."""
    reason = missing(result.sweep)
    if reason or name not in result:
        return Check(None, reason or "it is not stored")
    worst = -1.0
    for block in result.sweep.grid.blocks(block_cells(result.sweep.cell_bytes)):
        sizes = np.abs(result.part(name, block))
        worst = max(worst, float(np.max(sizes, where=np.isfinite(sizes), initial=-1.0)))
    return Check(worst) if worst >= 0 else Check(None, "no cell has it")
