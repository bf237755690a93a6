"""Tiles that raised: a text file for each with the traceback, so that a resumed run need not try them again."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass, field
from pathlib import Path

from quavsweep.grid import Tile
from quavsweep.provenance import Identity
from quavsweep.store.folder import RunFolder
from quavsweep.store.publish import publish_bytes

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
    traces : dict
        What each record says, by number of the tile; its last line is the error.
    """

    folder: Path
    tile_cells: int
    traces: dict[int, str] = field(default_factory=dict)

    @classmethod
    def scan(cls, run: RunFolder, identity: Identity, tile_cells: int) -> Failures:
        """Return the tiles that a run's folder knows to have raised."""
        failures = cls(run.failed / identity.evidence / identity.toolchain, tile_cells)
        for path in sorted(failures.folder.glob("tile-*.txt")):
            match = _NAME.fullmatch(path.name)
            if match and int(match[2]) == tile_cells:
                with contextlib.suppress(OSError):
                    failures.traces[int(match[1])] = path.read_text(errors="replace")
        return failures

    def _path(self, index: int) -> Path:
        return self.folder / f"tile-{index:07d}.{self.tile_cells}.txt"

    def add(self, tile: Tile, trace: str) -> None:
        """Record a tile that raised.

        Raises
        ------
        DiskError
            If it cannot be written.
        """
        text = f"tile {tile.index}, cells {tile.start} to {tile.stop - 1}\n{trace}"
        publish_bytes(self._path(tile.index), text.encode(errors="replace"))
        self.traces[tile.index] = text

    def forget(self) -> None:
        """Remove all records, so that these tiles are tried again."""
        for index in self.traces:
            with contextlib.suppress(OSError):
                self._path(index).unlink()
        self.traces = {}

    @property
    def first_error(self) -> str:
        """The error of the first of them, in a line; empty if there is none."""
        lines = self.traces[min(self.traces)].strip().splitlines() if self.traces else []
        return lines[-1] if lines else ""
