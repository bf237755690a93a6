"""The shards of a sweep: which tiles they cover, and their evidence as a stream of blocks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from quavsweep.codes import Status
from quavsweep.config import Sweep
from quavsweep.content import content_of, content_variables
from quavsweep.errors import DamageError
from quavsweep.grid import Tile
from quavsweep.measures import Evidence
from quavsweep.provenance import Identity
from quavsweep.store.evidence import LARGEST, read_shard
from quavsweep.store.folder import RunFolder
from quavsweep.store.shard import (
    Shard,
    digest_of,
    known_shards,
    misfits,
    scan_shards,
    set_aside,
    write_shard,
)

Block = tuple[slice, ...]
UNKNOWN = 8192  # cells per tile for readers of a folder without shards


@dataclass
class ShardSet:
    """The valid shards of one identity in a folder; the only truth about what has been computed.

    Parameters
    ----------
    folder : Path
        Where their stages lie.
    sweep : Sweep
    identity : Identity
    tile_cells : int
        Cells per tile, that of the shards if there are any.
    shards : dict
        Of all cells of a tile at the end of the sweep, by number of the tile.
    begun : dict
        Of all cells of a tile at the last of the earlier ends, by number of the tile.
    passes : dict
        Of cells that went on beyond the end of the sweep, by number of the tile, then by end and digest of their list.
    doubles : list
        Where there are several of a kind, all but one; none of them is read, but by whoever looks for damage.
    """

    folder: Path
    sweep: Sweep
    identity: Identity
    tile_cells: int
    shards: dict[int, Shard] = field(default_factory=dict)
    begun: dict[int, Shard] = field(default_factory=dict)
    passes: dict[int, dict[tuple[int, str], Shard]] = field(default_factory=dict)
    doubles: list[Shard] = field(default_factory=list)
    _unread: set[Shard] = field(default_factory=set, repr=False)

    @classmethod
    def scan(cls, run: RunFolder, sweep: Sweep, identity: Identity, tile_cells: int = UNKNOWN) -> ShardSet:
        """Return the shards that a run's folder holds of a sweep; with none, tiles will have `tile_cells` cells."""
        folder = run.shards(identity.evidence, identity.toolchain)
        most = max(1, LARGEST // sweep.cell_bytes)  # a hostile name tells of tiles that no memory holds
        found = [shard for shard in scan_shards(folder) if shard.end >= 0 and shard.tile_cells <= most]
        layouts = Counter(shard.tile_cells for shard in found)
        if layouts:
            tile_cells = max(layouts, key=lambda cells: (layouts[cells] * cells, cells))
        tile_cells = min(tile_cells, most)
        shards = cls(folder, sweep, identity, tile_cells)
        for shard in sorted(found, key=lambda shard: shard.end):
            if shard.tile_cells == tile_cells:
                shards.add(shard)
        return shards

    def names(self, index: int) -> tuple[str, ...]:
        """Return the names of the shards of one tile, by which another process can `find` them."""
        of_all = (shards[index] for shards in (self.begun, self.shards) if index in shards)
        return tuple(shard.name for shard in (*of_all, *self.passes.get(index, {}).values()))

    def find(self, index: int, names: Iterable[str] | None = None) -> None:
        """Take in the shards of one tile: those of these names, or all that lie in the folder, which is listed."""
        found = scan_shards(self.folder, index) if names is None else known_shards(self.folder, names)
        for shard in sorted(found, key=lambda shard: shard.end):
            if shard.tile_cells == self.tile_cells and shard.end >= 0:
                self.add(shard)

    @property
    def end(self) -> int:
        """The step at which the sweep ends."""
        return self.sweep.clock.steps

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
        """Take a shard in; of the earlier stages of a tile the last one added counts."""
        before: Shard | None = None
        self._unread.add(shard)
        if shard.listed:
            passes = self.passes.setdefault(shard.tile, {})
            before = passes.get(key := (shard.end, shard.listed))
            passes[key] = shard
        elif shard.end == self.end:
            before = self.shards.get(shard.tile)
            self.shards[shard.tile] = shard
        elif shard.end < self.end:
            self.begun[shard.tile] = shard
        if before not in (None, shard):
            self.doubles.append(before)

    def write(self, tile: Tile, evidence: Evidence, begin: int, end: int) -> Shard:
        """Publish the evidence of a tile, or of some of its cells, that a stage led from one step to another.

        Raises
        ------
        DiskError
            If it cannot be written.
        """
        cells, variables = evidence["cell"], content_variables(self.sweep)
        listed = "" if end == self.end else digest_of(cells)
        folder = self.folder / f"{begin}-{end}"
        content = content_of(self.sweep, evidence)
        return write_shard(folder, tile, self.tile_cells, variables, content, self.identity, listed)

    def begin(self, index: int) -> tuple[int, Evidence | None]:
        """Return the step from which a tile can go on, and its evidence there; 0 and None if it begins anew."""
        shard = self.begun.get(index)
        if shard is None:
            return 0, None
        try:
            return shard.end, self._read(shard)
        except DamageError:
            set_aside(self.begun.pop(index))
            return 0, None

    def read(self, index: int, failed: Mapping[int, str]) -> Evidence:
        """Return a tile's content at the end of the sweep; without shard its status is not_computed or failed.

        Raises
        ------
        DamageError
            If the shard's content is not what was published.
        """
        if index in self.shards:
            return self._read(self.shards[index])
        tile, variables = self.tile(index), self.sweep.measures.evidence
        evidence = {v.name: v.empty(len(tile), self.sweep.extents) for v in variables}
        evidence["cell"][:] = np.arange(tile.start, tile.stop)
        evidence["status"][:] = Status.FAILED if index in failed else Status.NOT_COMPUTED
        return content_of(self.sweep, evidence)

    def read_pass(self, index: int, end: int, cells: np.ndarray) -> Evidence | None:
        """Return the evidence of some cells of a tile that went on to a later end, None if they have not.

        Raises
        ------
        DamageError
            If the shard's content is not what was published.
        """
        shard = self.passes.get(index, {}).get((end, digest_of(cells)))
        return None if shard is None else self._read(shard)

    def _read(self, shard: Shard) -> Evidence:
        sweep = self.sweep.until(shard.end)
        self._unread.discard(shard)
        return read_shard(shard, self.tile(shard.tile), content_variables(sweep), sweep.extents, self.identity)

    def __iter__(self) -> Iterator[Shard]:
        """Yield every shard."""
        yield from self.shards.values()
        yield from self.begun.values()
        for shards in self.passes.values():
            yield from shards.values()
        yield from self.doubles

    def discard_damaged(self, *, unread: bool = False) -> list[int]:
        """Verify every shard, set the damaged ones aside, and return the numbers of their tiles.

        With `unread` only those that nobody has read so far: of shorter runs, and of passes for other thresholds.
        """
        looked_at = [*self._unread] if unread else [*self]
        damaged = {shard for shard, _ in self._damaged(looked_at)}
        for shard in damaged:
            set_aside(shard)
        kept = sorted({*self} - damaged, key=lambda shard: (shard.end, shard.path))
        self.shards, self.begun, self.passes, self.doubles = {}, {}, {}, []
        for shard in kept:
            self.add(shard)
        return sorted({shard.tile for shard in damaged})

    def damage(self) -> dict[Shard, str]:
        """Verify every shard; return what is wrong with the damaged ones."""
        return dict(self._damaged(self))

    def _damaged(self, shards: Iterable[Shard]) -> Iterable[tuple[Shard, str]]:
        for shard in sorted(shards, key=lambda shard: (shard.tile, shard.end)):
            try:
                self._read(shard)
            except DamageError as error:
                yield shard, str(error)

    def truncated(self) -> list[str]:
        """Return a sentence for each file that has a shard's name but not its size; a scan passes it over."""
        return [f"{path}: has not the size that its name tells" for path in misfits(self.folder)]
