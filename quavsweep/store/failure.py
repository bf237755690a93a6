"""Tiles that raised: a text file for each with the traceback, so that a resumed run need not try them again."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass, field
from pathlib import Path

from quavsweep.grid import Tile
from quavsweep.provenance import Identity
from quavsweep.store.folder import RunFolder
from quavsweep.whole import plain_file, publish_bytes

LONGEST = 4096  # bytes that are read of a record
_NAME = re.compile(r"tile-(\d{7,})\.(\d+)\.txt")


@dataclass
class Failures:
    """The tiles of one identity and layout that raised.

    Parameters
    ----------
    folder : Path
        Where their records lie.
    tile_cells : int
        Cells per tile.
    errors : dict
        The error of each, in a line, by number of the tile.
    """

    folder: Path
    tile_cells: int
    errors: dict[int, str] = field(default_factory=dict)

    @classmethod
    def scan(cls, run: RunFolder, identity: Identity, tile_cells: int) -> Failures:
        """Return the tiles that a run's folder knows to have raised."""
        failures = cls(run.failed / identity.evidence / identity.toolchain, tile_cells)
        for path in sorted(failures.folder.glob("tile-*.txt")):
            match = _NAME.fullmatch(path.name)
            if match and int(match[2]) == tile_cells:
                with contextlib.suppress(OSError), plain_file(path) as file:
                    first = file.read(LONGEST).decode(errors="replace").partition("\n")[0]
                    failures.errors[int(match[1])] = first.partition(": ")[2]
        return failures

    def _path(self, index: int) -> Path:
        return self.folder / f"tile-{index:07d}.{self.tile_cells}.txt"

    def add(self, tile: Tile, error: str, trace: str) -> None:
        """Record a tile that raised, with its error in a line and the traceback.

        Raises
        ------
        DiskError
            If it cannot be written.
        """
        text = f"tile {tile.index}, cells {tile.start} to {tile.stop - 1}: {error}\n{trace}"
        publish_bytes(self._path(tile.index), text.encode(errors="replace"))
        self.errors[tile.index] = error

    def forget(self) -> None:
        """Remove all records, so that these tiles are tried again."""
        for index in self.errors:
            with contextlib.suppress(OSError):
                self._path(index).unlink()
        self.errors = {}

    @property
    def first_error(self) -> str:
        """The error of the first of them; empty if there is none."""
        return self.errors[min(self.errors)] if self.errors else ""
