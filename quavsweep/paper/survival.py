"""How much of the chaos of a map is still chaos in the end: a count."""

from __future__ import annotations

import numpy as np

from quavsweep.codes import REGION, Region
from quavsweep.paper.interval import HORIZON
from quavsweep.paper.item import Table
from quavsweep.result import Result


def fate_of_chaos(seen: Result, end: Result) -> tuple[Table, str]:
    """Return what becomes of the cells that are chaotic at the horizon, as a table and in a sentence."""
    before, after = seen["region"].ravel(), end["region"].ravel()
    chaos = before == Region.CHAOS
    counts = np.bincount(after[chaos], minlength=len(REGION))
    total = int(chaos.sum())
    last = end.sweep.most_steps * end.sweep.clock.dt
    rows = [(code.meaning, f"{n:,}", _share(int(n), total)) for code, n in zip(REGION, counts, strict=True) if n]
    title = f"Where the {total:,} cells that are chaotic at {HORIZON:,.0f} s are at {last:,.0f} s"
    kept = int(counts[Region.CHAOS])
    text = (
        f"At {HORIZON:,.0f} s {_share(total, before.size)} of the {before.size:,} cells are chaotic, and of these "
        f"{_share(kept, total)} still are at {last:,.0f} s."
    )
    return Table(title, ("region", "cells", "share"), rows), text


def _share(count: int, total: int) -> str:
    """Return a share with its binomial standard error; the grid is no random sample, so the error is a scale."""
    if not total:
        return "none"
    share = count / total
    return f"{100 * share:.1f} +- {100 * np.sqrt(share * (1 - share) / total):.1f} %"


def trend(seen: Result) -> str:
    """Return whether chaos moves to larger or smaller values of the first axis as the second grows, in a word.

    It is the sign of the slope of the mean place of chaotic cells, each row of the map weighted by their number.
    """
    across, up = (np.asarray(axis.values) for axis in seen.sweep.grid.axes)
    chaos = seen["region"] == Region.CHAOS
    if not chaos.any():
        return "no chaos"
    x, y = (values[i] for values, i in zip((across, up), np.nonzero(chaos), strict=True))
    covariance = float(((x - x.mean()) * (y - y.mean())).sum())
    return "larger" if covariance > 0 else "smaller"
