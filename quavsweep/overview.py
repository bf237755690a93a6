"""How far the run in a folder is, from its files alone and in a fraction of a second."""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.codes import REGION, STATUS, Status
from quavsweep.config import Sweep, load_sweep
from quavsweep.errors import DamageError, IdentityError
from quavsweep.provenance import Identity, identify, subject
from quavsweep.store import Failures, RunFolder, ShardSet, code_counts, read_result, strangers

LOOK_SECONDS = 0.15  # spent on reading shards of an unfinished run


@dataclass
class Overview:
    """What a folder holds.

    Parameters
    ----------
    sweep : Sweep
    tiles, tiles_done, cells_done : int
        Of the run; no tiles are known before the first is done.
    failed : int
        Cells whose tile raised.
    regions : dict
        From a region's name to its number of cells, among the `looked_at` cells.
    result : str
        Path of the result; empty if there is none yet.
    damaged : str
        What is wrong with a result that is there and cannot be read; empty if nothing is.
    holder : str
        Who is running it; empty if nobody is.
    ignored : tuple of str
        What lies in the folder and is not of this run.
    """

    sweep: Sweep
    tiles: int
    tiles_done: int
    cells_done: int
    failed: int
    regions: dict[str, int]
    looked_at: int
    result: str
    damaged: str
    holder: str
    ignored: tuple[str, ...]

    @property
    def complete(self) -> bool:
        """Whether there is a result that has every cell."""
        return bool(self.result) and "none" not in self.regions

    def to_json(self) -> dict[str, Any]:
        """Return it as data for other programs."""
        return {
            "name": self.sweep.name,
            "model": self.sweep.model.name,
            "axes": {axis.name: len(axis) for axis in self.sweep.grid.axes},
            "cells": self.sweep.grid.size,
            "cells_done": self.cells_done,
            "tiles": self.tiles,
            "tiles_done": self.tiles_done,
            "cells_failed": self.failed,
            "complete": self.complete,
            "regions": self.regions,
            "regions_of_cells": self.looked_at,
            "result": self.result or None,
            "damaged": self.damaged or None,
            "running": self.holder or None,
            "ignored": list(self.ignored),
        }


@dataclass
class Lookout:
    """Looks at a folder again and again; shards that it has read before are not read again."""

    folder: RunFolder
    _counts: dict[str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, path: Path) -> Lookout:
        """Return the lookout over a run's folder.

        Raises
        ------
        ConfigError
            If it is none.
        """
        folder = RunFolder(path.parent if path.name == "result.h5" else path)
        folder.must_exist()
        return cls(folder)

    def look(self) -> Overview:
        """Return what the folder holds now."""
        folder = self.folder
        sweep = load_sweep(folder.config)
        shards = self._shards(sweep)
        finished, failed, damaged = False, 0, ""
        try:
            stored = read_result(folder.result)
            failed = int(code_counts(stored, "status", STATUS)[Status.FAILED])
            count = code_counts(stored, "region", REGION)
            finished = True
        except FileNotFoundError:
            pass
        except DamageError as error:
            damaged = str(error)
        if not finished:
            count = self._count(shards)
            failed = self._failed(shards)
        return Overview(
            sweep=sweep,
            tiles=shards.tiles if shards else 0,
            tiles_done=len(shards.shards) if shards else 0,
            cells_done=shards.cells_done if shards else 0,
            failed=failed,
            regions={code.name: int(n) for code, n in zip(REGION, count, strict=True) if n},
            looked_at=int(count.sum()),
            result=str(folder.result) if finished else "",
            damaged=damaged,
            holder=folder.holder,
            ignored=self._ignored(shards),
        )

    def _shards(self, sweep: Sweep) -> ShardSet | None:
        """Return the shards of the run, if there are any."""
        present = self.folder.identities()
        if not present:
            return None
        # Only where several versions have left shards does it take long to know whose are meant.
        sole = len(present) == 1
        identity = (
            Identity(*present[0], end="", rules="", subject=subject(sweep))
            if sole
            else self.folder.present_identity(identify(sweep))
        )
        return ShardSet.scan(self.folder, sweep, identity)

    def _failed(self, shards: ShardSet | None) -> int:
        """Return the cells of tiles that raised."""
        if shards is None:
            return 0
        failures = Failures.scan(self.folder, shards.identity, shards.tile_cells)
        return sum(len(shards.tile(index)) for index in failures.errors)

    def _ignored(self, shards: ShardSet | None) -> tuple[str, ...]:
        """Return what lies in the folder and is not of this run."""
        if shards is None:
            return ()
        return tuple(strangers(self.folder, shards.identity.evidence, shards.identity.toolchain))

    def _count(self, shards: ShardSet | None) -> np.ndarray:
        """Return the cells per region in the shards, as far as they can be read in a short time."""
        if shards is None:
            return np.zeros(len(REGION), dtype=int)
        from quavsweep.content import region_counts  # what a finished run need not load
        from quavsweep.tiling import spread

        deadline = time.monotonic() + LOOK_SECONDS
        for tile in spread(shards.tile(index) for index in shards.shards):
            index, shard = tile.index, shards.shards[tile.index]
            if shard.sha256 not in self._counts:
                with contextlib.suppress(DamageError, IdentityError):
                    self._counts[shard.sha256] = region_counts(shards.sweep, shards.read(index, {}))
            if time.monotonic() > deadline:
                break
        return sum(self._counts.values(), start=np.zeros(len(REGION), dtype=int))
