"""The shards of a sweep: which tiles they cover, and their evidence as a stream of blocks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from quavsweep.codes import Status
from quavsweep.config import Sweep
from quavsweep.errors import DamageError
from quavsweep.grid import Tile
from quavsweep.measures import Evidence
from quavsweep.provenance import Identity
from quavsweep.store.folder import RunFolder
from quavsweep.store.shard import Shard, misfits, read_shard, scan_shards, set_aside

Block = tuple[slice, ...]
UNKNOWN = 8192  # cells per tile for readers of a folder without shards


@dataclass
class ShardSet:
    """The valid shards of one identity in a folder; the only truth about what has been computed.

    Parameters
    ----------
    folder : Path
        Where they lie.
    sweep : Sweep
    identity : Identity
    tile_cells : int
        Cells per tile, that of the shards if there are any.
    shards : dict
        By number of the tile.
    """

    folder: Path
    sweep: Sweep
    identity: Identity
    tile_cells: int
    shards: dict[int, Shard] = field(default_factory=dict)

    @classmethod
    def scan(cls, run: RunFolder, sweep: Sweep, identity: Identity, tile_cells: int = UNKNOWN) -> ShardSet:
        """Return the shards that a run's folder holds of a sweep; with none, tiles will have `tile_cells` cells."""
        folder = run.shards(identity.evidence, identity.toolchain, identity.stage)
        found = [shard for same in scan_shards(folder).values() for shard in same]
        layouts = Counter(shard.tile_cells for shard in found)
        if layouts:
            tile_cells = max(layouts, key=lambda cells: (layouts[cells] * cells, cells))
        return cls(folder, sweep, identity, tile_cells, {s.tile: s for s in found if s.tile_cells == tile_cells})

    @property
    def tiles(self) -> int:
        """Number of tiles in all."""
        return -(-self.sweep.grid.size // self.tile_cells)

    def tile(self, index: int) -> Tile:
        """Return the tile of that number."""
        start = index * self.tile_cells
        return Tile(index, start, min(start + self.tile_cells, self.sweep.grid.size))

    @property
    def cells_done(self) -> int:
        """Number of cells that shards cover."""
        return sum(len(self.tile(index)) for index in self.shards)

    def missing(self) -> list[Tile]:
        """Return the tiles that no shard covers, in order."""
        return [self.tile(index) for index in range(self.tiles) if index not in self.shards]

    def add(self, shard: Shard) -> None:
        """Take a newly published shard in."""
        self.shards[shard.tile] = shard

    def read(self, index: int, failed: Mapping[int, str]) -> Evidence:
        """Return a tile's evidence; a tile without shard has the status not_computed or failed.

        Raises
        ------
        DamageError
            If the shard's content is not what was published.
        """
        tile, variables = self.tile(index), self.sweep.measures.evidence
        if index in self.shards:
            return read_shard(self.shards[index], tile, variables, self.sweep.extents, self.identity)
        evidence = {v.name: v.empty(len(tile), self.sweep.extents) for v in variables}
        evidence["cell"][:] = np.arange(tile.start, tile.stop)
        evidence["status"][:] = Status.FAILED if index in failed else Status.NOT_COMPUTED
        return evidence

    def discard_damaged(self) -> list[int]:
        """Verify every shard, set the damaged ones aside, and return the numbers of their tiles."""
        damaged = sorted(self.damage())
        for index in damaged:
            set_aside(self.shards.pop(index))
        return damaged

    def damage(self) -> dict[int, str]:
        """Verify every shard; return what is wrong with the damaged ones, by the numbers of their tiles."""
        found = {}
        for index in sorted(self.shards):
            try:
                self.read(index, {})
            except DamageError as error:
                found[index] = str(error)
        return found

    def truncated(self) -> list[str]:
        """Return a sentence for each file that has a shard's name but not its size; a scan passes it over."""
        return [f"{path}: has not the size that its name tells" for path in misfits(self.folder)]

    def blocks(self, cells: int, failed: Mapping[int, str]) -> Iterator[tuple[Block, Evidence]]:
        """Yield the evidence of the grid's blocks, in order, reading each shard once.

        Raises
        ------
        DamageError
            See `read`.
        """
        held: dict[int, Evidence] = {}
        for block in self.sweep.grid.blocks(cells):
            start, stop = self.sweep.grid.span(block)
            needed = range(start // self.tile_cells, (stop - 1) // self.tile_cells + 1)
            held = {i: held[i] if i in held else self.read(i, failed) for i in needed}
            parts = []
            for index, evidence in held.items():
                offset = index * self.tile_cells
                inside = slice(max(start - offset, 0), stop - offset)
                parts.append({name: values[inside] for name, values in evidence.items()})
            whole = len(parts) == 1
            yield block, parts[0] if whole else {n: np.concatenate([part[n] for part in parts]) for n in parts[0]}
