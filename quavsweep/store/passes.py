"""Passes of the effort in shards, and evidence with them as a stream of blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from quavsweep.grid import Tile
from quavsweep.measures import Evidence
from quavsweep.passes import GoOn, with_passes
from quavsweep.store.shard import Shard
from quavsweep.store.shard_set import Block, ShardSet


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
        evidence, left = with_passes(shards.sweep, shards.read(index, failed), stored_passes(shards, index))
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
