"""From what was measured on small sweeps to a plan for a large one: a table, and what it assumes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

CORES = 1000
ASSUMPTIONS = (
    "cells like those of configs/omega_c.yaml on average, on cores like this one",
    "times per cell, per byte and per shard stay what they are here: the disk delivers as fast as it is read",
    "consolidation, verify and the scan run in one process; the file system holds that many files in one folder",
)


@dataclass(frozen=True)
class Measured:
    """What a small sweep of the same kind took.

    Parameters
    ----------
    tile_cells : int
        Of the large sweep, by the cost model.
    core_seconds : float
        To integrate a cell [s].
    shard_bytes : dict
        Per cell, by kind of evidence.
    result_bytes : float
        Per cell.
    consolidated : dict
        Cells per second, by kind of evidence.
    verified, hashed : float
        Shards and the result checked [bytes/s].
    scanned : float
        Shards that a scan finds [1/s].
    driver_bytes, shard_memory : float
        Memory of the driver without shards, and for each.
    scheduled : float
        Tiles that the scheduler can hand out [1/s].
    """

    tile_cells: int
    core_seconds: float
    shard_bytes: dict[str, float]
    result_bytes: float
    consolidated: dict[str, float]
    verified: float
    hashed: float
    scanned: float
    driver_bytes: float
    shard_memory: float
    scheduled: float


def rows(measured: Measured, cells: int) -> Iterator[tuple[str, str]]:
    """Yield what a sweep of so many cells takes: a name, and a number with its unit."""
    tiles = -(-cells // measured.tile_cells)
    tile_seconds = measured.tile_cells * measured.core_seconds
    core_hours = cells * measured.core_seconds / 3600
    yield "tiles, shards, inodes", f"{tiles:,} of {measured.tile_cells:,} cells, {tile_seconds:.2g} s each"
    yield "core hours", f"{core_hours:,.0f}; {core_hours / CORES:.2g} h on {CORES:,} cores"
    yield (
        "tiles per second",
        f"{CORES / tile_seconds:.3g} on {CORES:,} cores; {measured.scheduled:.3g} can be handed out",
    )
    yield "memory of the driver", f"{(measured.driver_bytes + tiles * measured.shard_memory) / 1e9:.2g} GB"
    yield "resume scan", f"{tiles / measured.scanned:.3g} s"
    for evidence, size in measured.shard_bytes.items():
        total = cells * size
        yield f"shards, {evidence}", f"{total / 1e12:.2g} TB; {total / tiles / 1e6:.2g} MB each"
        yield f"consolidation, {evidence}", f"{cells / measured.consolidated[evidence] / 3600:.3g} h"
        yield f"verify, {evidence}", f"{total / measured.verified / 3600:.2g} h"
    result = cells * measured.result_bytes
    yield (
        "result.h5",
        f"{result / 1e12:.2g} TB; opened in {result / measured.hashed / 60:.2g} min, its seal being checked",
    )
