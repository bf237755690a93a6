"""Reading shards: their bytes are checked against their name, then poured out of a mould, without HDF5.

A shard that does not fit its mould, because another version of HDF5 wrote it or because it is damaged or hostile, is
read by the process that reads files from elsewhere.
"""

from __future__ import annotations

import hashlib
import os
from typing import IO

import numpy as np

from quavsweep.errors import PASSING_ERRNOS, DamageError, DiskError, IdentityError
from quavsweep.grid import Tile
from quavsweep.measures import Evidence, Variable
from quavsweep.provenance import Identity
from quavsweep.store.foreign import ForeignFile
from quavsweep.store.mould import moulder
from quavsweep.store.shard import Shard, digest_of

LARGEST = 2**28  # bytes; a tile has a fraction of that


def read_shard(
    shard: Shard, tile: Tile, variables: tuple[Variable, ...], extents: dict[str, int], identity: Identity
) -> Evidence:
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
        with shard.path.open("rb") as raw:
            data = _verified(raw, shard)
            owner = identity.owner(shard.path.parent.name)
            moulds = moulder(owner, identity.subject, variables, tuple(extents.items()))
            n = moulds.cells(len(data)) if shard.listed else len(tile)
            fits = 0 < n <= len(tile) and moulds.cells(len(data)) == n
            evidence = moulds.mould(n).cast(data, tile) if fits else None
            del data
            if evidence is None:
                evidence = _read_elsewhere(raw, shard, tile, variables, identity)
    except OSError as error:
        passing = isinstance(error, PermissionError) or error.errno in PASSING_ERRNOS
        raise (DiskError if passing else DamageError)(f"cannot be read: {error.strerror}", str(shard.path)) from error
    _check(shard, tile, variables, extents, evidence)
    return evidence


def _verified(raw: IO[bytes], shard: Shard) -> bytearray:
    """Return the bytes of an open shard if they are those that its name tells."""
    size = os.fstat(raw.fileno()).st_size
    if size > LARGEST:
        raise DamageError("is larger than shards are", str(shard.path))
    data = bytearray(size)
    view = memoryview(data)
    while view and (got := raw.readinto(view)):  # type: ignore[attr-defined]
        view = view[got:]
    if view or hashlib.sha256(data).hexdigest() != shard.sha256:
        raise DamageError("its bytes are not those that were written", str(shard.path))
    return data


def _read_elsewhere(
    raw: IO[bytes], shard: Shard, tile: Tile, variables: tuple[Variable, ...], identity: Identity
) -> Evidence:
    """Return the evidence of an open shard as another process reads it."""
    foreign = ForeignFile(raw, str(shard.path))
    told = foreign.attributes
    numbers = np.asarray(told.get("tile", ())).tolist()
    if told.get("owner") != identity.owner(shard.path.parent.name) or numbers != [tile.index, tile.start, tile.stop]:
        raise DamageError("belongs to another tile or sweep", str(shard.path))
    if told.get("subject") != identity.subject or {v.name for v in variables} != set(foreign.variables):
        raise IdentityError(
            "was made with another config than config.yaml is now",
            str(shard.path),
            "delete config.yaml and run the sweep's own config, which writes it anew",
        )
    return {variable.name: foreign.read(variable.name) for variable in variables}


def _check(
    shard: Shard, tile: Tile, variables: tuple[Variable, ...], extents: dict[str, int], evidence: Evidence
) -> None:
    """Refuse evidence of other cells, shapes, types or codes than there can be."""
    n = len(evidence["cell"]) if shard.listed and evidence["cell"].ndim else len(tile)
    for variable in variables:
        values = evidence[variable.name]
        if values.shape != variable.shape(n, extents) or values.dtype != variable.dtype:
            raise DamageError(f"{variable.name} has another shape or type", str(shard.path))
        if variable.codes and not np.isin(values, [code.number for code in variable.codes]).all():
            raise DamageError(f"{variable.name} has a code that does not exist", str(shard.path))
    if shard.listed and digest_of(evidence["cell"]) != shard.listed:
        raise DamageError("holds other cells than its name tells", str(shard.path))
    cells = evidence["cell"]
    expected = cells if shard.listed else np.arange(tile.start, tile.stop)
    if not np.array_equal(cells, expected) or (cells < tile.start).any() or (cells >= tile.stop).any():
        raise DamageError("holds cells of another tile", str(shard.path))
