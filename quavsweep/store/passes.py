"""Passes: cells that are undecided at the end of a sweep go on, each pass twice as long, from their checkpoints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from quavsweep.classify import undecided
from quavsweep.codes import Status
from quavsweep.config import Sweep
from quavsweep.grid import Tile
from quavsweep.measures import Evidence
from quavsweep.store.shard import Shard
from quavsweep.store.shard_set import Block, ShardSet

GoOn = Callable[[int, int, Evidence], Evidence | None]  # from an end to the next: evidence of cells to theirs there


def with_passes(shards: ShardSet, index: int, evidence: Evidence, go_on: GoOn) -> tuple[Evidence, int]:
    """Return a tile's evidence with what the passes of the effort added, and how many cells wait for a pass.

    Which cells go through a pass follows from the evidence at the end of the one before and the thresholds alone.

    Parameters
    ----------
    shards : ShardSet
    index : int
        Number of the tile.
    evidence : dict of arrays
        Of all its cells at the end of the sweep.
    go_on : callable
        Gives the evidence of cells at a later end, or None if it is not there.
    """
    sweep, begin = shards.sweep, shards.end
    for end in sweep.pass_ends():
        rows = np.flatnonzero(undecided(sweep.until(begin), evidence) & may_go_on(evidence, begin))
        if not rows.size:
            break
        longer = go_on(begin, end, {name: values[rows] for name, values in evidence.items()})
        if longer is None:
            return evidence, rows.size
        evidence = _merged(sweep.until(end), evidence, rows, longer)
        begin = end
    return evidence, 0


def may_go_on(evidence: Evidence, end: int) -> np.ndarray:
    """Return which cells were integrated to an end and have not ended there, (n,) bool."""
    return np.asarray((evidence["status"] == Status.TIME_OVER) & (evidence["steps"] == end))


def _merged(sweep: Sweep, evidence: Evidence, rows: np.ndarray, longer: Evidence) -> Evidence:
    """Return evidence of a tile in which some cells have gone on; the others have nothing there."""
    merged = {}
    for variable in sweep.measures.evidence:
        values = evidence[variable.name]
        wide = variable.empty(len(values), sweep.extents)
        wide[tuple(slice(0, length) for length in values.shape)] = values
        wide[rows] = longer[variable.name]
        merged[variable.name] = wide
    return merged


def stored_passes(shards: ShardSet, index: int) -> GoOn:
    """Return the passes of a tile that lie in shards."""

    def go_on(begin: int, end: int, evidence: Evidence) -> Evidence | None:
        return shards.read_pass(index, end, evidence["cell"])

    return go_on


def blocks(
    shards: ShardSet, cells: int, failed: Mapping[int, str], waiting: dict[int, int]
) -> Iterator[tuple[Block, list[Evidence]]]:
    """Yield the evidence of the grid's blocks, in order, reading each shard once.

    Parameters
    ----------
    waiting : dict
        Gets the number of cells that wait for a pass, by number of the tile.

    Yields
    ------
    block : tuple of slices
    parts : list of evidence
        Of its cells, in order; parts may have gone on to different ends.

    Raises
    ------
    DamageError
        If a shard's content is not what was published.
    """
    grid, size = shards.sweep.grid, shards.tile_cells
    held: dict[int, Evidence] = {}

    def read(index: int) -> Evidence:
        evidence, left = with_passes(shards, index, shards.read(index, failed), stored_passes(shards, index))
        waiting.update({index: left} if left else {})
        return evidence

    for block in grid.blocks(cells):
        start, stop = grid.span(block)
        needed = range(start // size, (stop - 1) // size + 1)
        held = {i: held[i] if i in held else read(i) for i in needed}
        parts = []
        for index, evidence in held.items():
            inside = slice(max(start - index * size, 0), stop - index * size)
            parts.append({name: values[inside] for name, values in evidence.items()})
        yield block, parts


def integrated_passes(
    shards: ShardSet, tile: Tile, continued: Callable[[int, Evidence], Evidence], done: list[Shard]
) -> GoOn:
    """Return passes that are integrated and published where no shard holds them.

    Parameters
    ----------
    continued : callable
        From an end and evidence of cells to their evidence there.
    done : list
        Gets the shards that were published.
    """
    stored = stored_passes(shards, tile.index)

    def go_on(begin: int, end: int, evidence: Evidence) -> Evidence | None:
        longer = stored(begin, end, evidence)
        if longer is None:
            longer = continued(end, evidence)
            done.append(shards.write(tile, longer, begin, end))
        return longer

    return go_on
