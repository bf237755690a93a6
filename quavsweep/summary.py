"""What a result holds in a few numbers: cells per region, how many were chaotic, the worst self-check."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quavsweep.codes import REGION, Region
from quavsweep.grid import Tile
from quavsweep.kernels.lookup import make_program
from quavsweep.plan import cell_values
from quavsweep.result import Result
from quavsweep.store import block_cells


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
    sum_error : float, optional
        Largest distance of the sum of all exponents, as averaged, from the divergence [1/time]; None where not all
        exponents are known, or where the divergence depends on the state.
    """

    cells: int
    regions: dict[str, int]
    was_chaotic: int | None
    sum_error: float | None


def summarise(result: Result) -> Summary:
    """Return a result in a few numbers."""
    region = result["region"]
    count = np.bincount(region.ravel(), minlength=len(REGION))
    regions = {code.name: int(n) for code, n in zip(REGION, count, strict=True) if n}
    on_the_way = None
    if "was_chaotic" in result:
        on_the_way = int(((result["was_chaotic"] != 0) & (region != Region.CHAOS)).sum())
    return Summary(region.size, regions, on_the_way, _worst_sum(result))


def _worst_sum(result: Result) -> float | None:
    """Return the largest distance of the raw sums from the divergence, if that does not depend on the state."""
    model = result.sweep.model
    if result.sweep.measures.trace:
        return None  # the last exponent was made of the sum
    if "lyapunov_raw" not in result or len(result["exponent"]) < len(model.states):
        return None
    program = make_program(model)
    diagonal = [row[i] for i, row in enumerate(program.jacobian)]
    grid, worst, known = result.sweep.grid, 0.0, False
    for block in grid.blocks(block_cells(result.sweep.cell_bytes)):
        sums = result.part("lyapunov_raw", block).sum(axis=-1).ravel()
        parameters, u = cell_values(result.sweep, Tile(0, *grid.span(block)))
        # A state that is not a number shows in whatever depends on it.
        names = program.names(np.full_like(u.T, np.nan), program.coefficient_values(parameters), np.nan)
        divergence = sum(program.evaluate(diagonal, names))
        if not np.isfinite(divergence).all():
            return None
        errors = np.abs(sums - divergence)[np.isfinite(sums)]
        worst, known = float(errors.max(initial=worst)), known or errors.size > 0
    return worst if known else None
