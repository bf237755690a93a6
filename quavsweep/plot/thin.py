"""Fewer cells for large grids: of each axis no more values than a figure shows, so that no more is read or held."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from quavsweep.result import Result

MOST = {1: 20_000, 2: 1500}  # values along an axis by the number of axes; a map is at most 1050 dots of print wide


def thinned(result: Result) -> Result:
    """Return a result at evenly spaced values of its axes, as many as a figure shows; as it is if there are no more."""
    axes = result.sweep.grid.axes
    chosen = {axis.name: _chosen(len(axis), MOST.get(len(axes), len(axis))) for axis in axes}
    return result if all(along.step == 1 for along in chosen.values()) else result.thinned(chosen)


def thinned_text(result: Result) -> str:
    """Return how many cells a result over some of them has, in words; empty where it has all."""
    if not result.thinned_from:
        return ""
    kept = zip(result.sweep.grid.shape, result.thinned_from, strict=True)
    return f"drawn: {' x '.join(f'{some:,} of {every:,}' for some, every in kept)} cells"


def _chosen(n: int, most: int) -> range:
    """Return evenly spaced indices of an axis, as far from one end as from the other."""
    step = max(1, -(-n // most))
    return range((n - 1) % step // 2, n, step)
