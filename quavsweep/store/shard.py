"""Shards: one file per tile and stage, named by its size and SHA-256, holding evidence and a checkpoint, no label.

A stage leads from one step to another. Its shards hold all evidence from t = 0 on, so the last one is all that a
reader needs; that of the stage before is where the next begins. A stage that only some cells of a tile go through
carries a digest of their list in its shard's name.

Where a sweep keeps no evidence, a shard holds what the classification made of it, see `quavsweep.content`.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import stat
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from quavsweep.grid import Tile
from quavsweep.measures import Variable
from quavsweep.provenance import Identity
from quavsweep.store.mould import fill_shard
from quavsweep.store.publish import publish_hdf5
from quavsweep.whole import sync_folder

_NAME = re.compile(r"tile-(\d{7,})\.(\d+)(?:\.cells-([0-9a-f]{16}))?\.(\d+)\.([0-9a-f]{64})\.h5")
_STAGE = re.compile(r"(\d{1,16})-(\d{1,16})")


@dataclass(frozen=True)
class Shard:
    """A published shard, as its name tells it.

    Parameters
    ----------
    path : Path
    tile : int
        Number of the tile.
    tile_cells : int
        Cells per tile in the layout that it belongs to.
    size : int
        Bytes.
    sha256 : str
        Of its content.
    listed : str
        Digest of the list of cells, empty where all cells of the tile are in it.
    """

    path: Path
    tile: int
    tile_cells: int
    size: int
    sha256: str
    listed: str = ""

    @property
    def is_there(self) -> bool:
        """Whether the file is there with its size."""
        with contextlib.suppress(OSError):
            return self.path.is_file() and self.path.stat().st_size == self.size
        return False

    @property
    def name(self) -> str:
        """Stage and name of the file."""
        return f"{self.path.parent.name}/{self.path.name}"

    @property
    def end(self) -> int:
        """The step to which its stage leads."""
        return stage_end(self.path.parent.name)


def stage_end(stage: str) -> int:
    """Return the step to which a stage leads, -1 for what is the name of none."""
    match = _STAGE.fullmatch(stage)
    return int(match[2]) if match else -1


def digest_of(cells: np.ndarray) -> str:
    """Return a digest of a list of cells, for a shard's name."""
    return hashlib.sha256(np.ascontiguousarray(cells, dtype="<i8").tobytes()).hexdigest()[:16]


def write_shard(
    folder: Path,
    tile: Tile,
    tile_cells: int,
    variables: tuple[Variable, ...],
    evidence: dict[str, np.ndarray],
    identity: Identity,
    listed: str = "",
) -> Shard:
    """Publish a tile's evidence and return its shard.

    Parameters
    ----------
    folder : Path
        Of the stage, whose name it bears.
    identity : Identity
        Of the evidence, written into the file.
    listed : str
        Digest of the list of cells, if they are not all of the tile's.

    Raises
    ------
    DiskError
        If it cannot be written.
    """

    def name(sha256: str, size: int) -> Path:
        cells = f".cells-{listed}" if listed else ""
        return folder / f"tile-{tile.index:07d}.{tile_cells}{cells}.{size}.{sha256}.h5"

    def write(file: h5py.File) -> None:
        numbers = tile.index, tile.start, tile.stop
        fill_shard(file, identity.owner(folder.name), identity.subject, numbers, variables, evidence)

    shard = _parse(publish_hdf5(name, write, in_memory=True))
    assert shard is not None
    return shard


def scan_shards(folder: Path, index: int | None = None) -> list[Shard]:
    """Return the shards of all stages, or those of one tile; names and sizes are trusted, content is verified later."""
    return [
        shard
        for shard, size in _named(folder, "tile-" if index is None else f"tile-{index:07d}.")
        if size == shard.size
    ]


def known_shards(folder: Path, names: Iterable[str]) -> list[Shard]:
    """Return the shards of these names, stage and file, that are there; nothing is listed."""
    shards = (_parse(folder / name) for name in names)
    return [shard for shard in shards if shard is not None and shard.is_there]


def misfits(folder: Path) -> list[Path]:
    """Return the files that have a shard's name but not its size."""
    return [shard.path for shard, size in _named(folder) if size != shard.size]


def _named(folder: Path, prefix: str = "tile-") -> Iterator[tuple[Shard, int]]:
    """Yield what has a shard's name in the folders of stages, in order, and its size, -1 where it is no file."""
    for stage in (folder / entry.name for entry in _listed(folder)):
        for entry in _listed(stage):
            shard = _parse(stage / entry.name) if entry.name.startswith(prefix) else None
            if shard is not None:
                yield shard, _size(entry)


def _listed(folder: Path) -> list[os.DirEntry[str]]:
    """Return what a folder holds, by name; nothing where it is none or may not be read."""
    with contextlib.suppress(FileNotFoundError, NotADirectoryError, PermissionError), os.scandir(folder) as entries:
        return sorted(entries, key=lambda entry: entry.name)
    return []


def _size(entry: os.DirEntry[str]) -> int:
    """Return the size of a file, asking the system once; -1 for what is none."""
    with contextlib.suppress(OSError):
        status = entry.stat()
        return status.st_size if stat.S_ISREG(status.st_mode) else -1
    return -1


def is_shard_name(name: str) -> bool:
    """Whether a file bears the name of a shard."""
    return _NAME.fullmatch(name) is not None


def _parse(path: Path) -> Shard | None:
    match = _NAME.fullmatch(path.name)
    return Shard(path, int(match[1]), int(match[2]), int(match[4]), match[5], match[3] or "") if match else None


def set_aside(shard: Shard) -> None:
    """Rename a bad shard so that no scan finds it, not even after a loss of power."""
    with contextlib.suppress(OSError):
        shard.path.rename(shard.path.with_suffix(".bad"))
        sync_folder(shard.path.parent)
