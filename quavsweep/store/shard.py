"""Shards: one file per tile, named by tile, size and SHA-256, holding evidence and a checkpoint, never a label."""

from __future__ import annotations

import contextlib
import hashlib
import io
import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from quavsweep.errors import DamageError, DiskError, IdentityError
from quavsweep.grid import Tile
from quavsweep.measures import Variable
from quavsweep.provenance import Identity
from quavsweep.store.publish import publish_hdf5

_NAME = re.compile(r"tile-(\d{7,})\.(\d+)\.(\d+)\.([0-9a-f]{64})\.h5")


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
    """

    path: Path
    tile: int
    tile_cells: int
    size: int
    sha256: str


def write_shard(
    folder: Path,
    tile: Tile,
    tile_cells: int,
    variables: tuple[Variable, ...],
    evidence: dict[str, np.ndarray],
    identity: Identity,
) -> Shard:
    """Publish a tile's evidence and return its shard.

    Parameters
    ----------
    identity : Identity
        Of the evidence, written into the file.

    Raises
    ------
    DiskError
        If it cannot be written.
    """

    def name(sha256: str, size: int) -> Path:
        return folder / f"tile-{tile.index:07d}.{tile_cells}.{size}.{sha256}.h5"

    def write(file: h5py.File) -> None:
        file.attrs["owner"] = identity.owner
        file.attrs["subject"] = identity.subject
        file.attrs["tile"] = np.array([tile.index, tile.start, tile.stop], dtype=np.int64)
        for variable in variables:
            file.create_dataset(variable.name, data=evidence[variable.name])

    shard = _parse(publish_hdf5(name, write, in_memory=True))
    assert shard is not None
    return shard


def scan_shards(folder: Path) -> dict[int, list[Shard]]:
    """Return the shards of a folder by tile, trusting names and sizes; their content is verified when it is used."""
    found: dict[int, list[Shard]] = {}
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):
        for path in sorted(folder.iterdir()):
            shard = _parse(path)
            if shard is not None and path.is_file() and path.stat().st_size == shard.size:
                found.setdefault(shard.tile, []).append(shard)
    return found


def misfits(folder: Path) -> list[Path]:
    """Return the files that have a shard's name but not its size."""
    shards = (_parse(path) for path in sorted(folder.glob("tile-*.h5")))
    return [s.path for s in shards if s is not None and not (s.path.is_file() and s.path.stat().st_size == s.size)]


def _parse(path: Path) -> Shard | None:
    match = _NAME.fullmatch(path.name)
    return Shard(path, int(match[1]), int(match[2]), int(match[3]), match[4]) if match else None


def read_shard(
    shard: Shard, tile: Tile, variables: tuple[Variable, ...], extents: dict[str, int], identity: Identity
) -> dict[str, np.ndarray]:
    """Return a shard's evidence after its content has been verified.

    Raises
    ------
    DamageError
        If its bytes are not those that were published, or not those of this tile and identity.
    IdentityError
        If it was made for other values than those of the config beside it.
    DiskError
        If it may not be read.
    """
    try:
        data = shard.path.read_bytes()
    except PermissionError as error:
        raise DiskError(f"cannot be read: {error.strerror}", str(shard.path)) from error
    except OSError as error:
        raise DamageError(f"cannot be read: {error.strerror}", str(shard.path)) from error
    if hashlib.sha256(data).hexdigest() != shard.sha256:
        raise DamageError("its bytes are not those that were written", str(shard.path))
    with h5py.File(io.BytesIO(data), "r") as file:
        described = list(file.attrs.get("tile", ()))
        if file.attrs.get("owner") != identity.owner or described != [tile.index, tile.start, tile.stop]:
            raise DamageError("belongs to another tile or sweep", str(shard.path))
        names = {variable.name for variable in variables}
        if file.attrs.get("subject") != identity.subject or names != set(file):
            raise IdentityError(
                "was made with another config than config.yaml is now",
                str(shard.path),
                "delete config.yaml and run the sweep's own config, which writes it anew",
            )
        evidence = {variable.name: file[variable.name][()] for variable in variables}
    for variable in variables:
        values = evidence[variable.name]
        if values.shape != variable.shape(len(tile), extents) or values.dtype != variable.dtype:
            raise DamageError(f"{variable.name} has another shape or type", str(shard.path))
    return evidence


def set_aside(shard: Shard) -> None:
    """Rename a bad shard so that no scan finds it."""
    with contextlib.suppress(OSError):
        shard.path.rename(shard.path.with_suffix(".bad"))
