"""Moulds of shards: all bytes of a shard but its data, known beforehand, so that HDF5 need not read any of them.

What HDF5 writes around data depends on names, types and shapes alone. It is written once more, from what is known of
the sweep; a shard that has the same bytes there holds its data where the mould has gaps for them.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import h5py
import numpy as np

from quavsweep.grid import Tile
from quavsweep.measures import Evidence, Variable

_LABELS = ((2**60 + 7, 2**61 + 11, 2**62 + 13), (3**37, 5**25, 7**21), (-11, -13, -17), (10**18, 10**17, 10**16))
_CHECKSUM = 4  # bytes that HDF5 appends to what holds the number of the tile


def fill_shard(
    file: h5py.File, owner: str, subject: str, tile: tuple[int, ...], variables: tuple[Variable, ...], data: Evidence
) -> None:
    """Write a shard's content into an open file."""
    file.attrs["owner"] = owner
    file.attrs["subject"] = subject
    file.attrs["tile"] = np.array(tile, dtype=np.int64)
    for variable in variables:
        file.create_dataset(variable.name, data=data[variable.name])


@dataclass(frozen=True)
class Mould:
    """What surrounds the data of n cells.

    Parameters
    ----------
    size : int
        Bytes of a shard.
    metal : tuple of (offset, bytes)
        All that is the same in every such shard.
    tile : int
        Offset of the numbers of the tile.
    gaps : dict
        Offset, type and shape of the data of each variable.
    """

    size: int
    metal: tuple[tuple[int, bytes], ...]
    tile: int
    gaps: Mapping[str, tuple[int, str, tuple[int, ...]]]

    def cast(self, data: bytearray, tile: Tile) -> Evidence | None:
        """Return the evidence in the bytes of a shard of this tile, None if they do not fit."""
        view = memoryview(data)
        numbers = np.array([tile.index, tile.start, tile.stop], dtype=np.int64).tobytes()
        if len(data) != self.size or view[self.tile : self.tile + len(numbers)] != numbers:
            return None
        if any(view[offset : offset + len(metal)] != metal for offset, metal in self.metal):
            return None
        return {
            name: np.frombuffer(data, dtype, int(np.prod(shape)), offset).reshape(shape).copy()
            for name, (offset, dtype, shape) in self.gaps.items()
        }


class Moulder:
    """Makes the moulds of the shards of a sweep.

    Parameters
    ----------
    owner, subject : str
        Which every shard bears.
    variables : tuple of Variable
    extents : tuple of (name, length)
    """

    def __init__(
        self, owner: str, subject: str, variables: tuple[Variable, ...], extents: tuple[tuple[str, int], ...]
    ) -> None:
        self.owner, self.subject, self.variables, self.extents = owner, subject, variables, dict(extents)
        empty = [self._bytes(0, label)[0] for label in _LABELS]
        self.overhead = len(empty[0])
        self.tile = bytes(empty[0]).find(np.array(_LABELS[0], dtype=np.int64).tobytes())
        rows = np.array([np.frombuffer(data, np.uint8) for data in empty])
        differ = np.flatnonzero((rows != rows[0]).any(axis=0))
        self.checksum = int(differ[-1]) - _CHECKSUM + 1
        self.cell_bytes = sum(v.empty(1, {**self.extents}).nbytes for v in variables)

    def cells(self, size: int) -> int:
        """Return how many cells a shard of that size holds, -1 if none can be so large."""
        n, rest = divmod(size - self.overhead, self.cell_bytes)
        return n if n > 0 and not rest else -1

    @lru_cache(maxsize=4)  # noqa: B019  moulders are few, and kept themselves
    def mould(self, n: int) -> Mould:
        """Return the mould of n cells."""
        data, places = self._bytes(n, _LABELS[0])
        gaps = {v.name: (places[v.name], v.dtype, v.shape(n, self.extents)) for v in self.variables}
        holes = [(self.tile, 3 * 8), (self.checksum, _CHECKSUM)]
        holes += [(offset, int(np.prod(shape)) * np.dtype(dtype).itemsize) for offset, dtype, shape in gaps.values()]
        metal, begin = [], 0
        for offset, length in sorted(holes):
            metal.append((begin, bytes(data[begin:offset])))
            begin = offset + length
        return Mould(len(data), (*metal, (begin, bytes(data[begin:]))), self.tile, gaps)

    def _bytes(self, n: int, label: tuple[int, ...]) -> tuple[memoryview, dict[str, int]]:
        """Return a shard of n empty cells, and where the data of each variable lie."""
        memory = io.BytesIO()
        with h5py.File(memory, "w", libver=("v110", "v110")) as file:
            empty = {v.name: np.zeros(v.shape(n, self.extents), v.dtype) for v in self.variables}
            fill_shard(file, self.owner, self.subject, label, self.variables, empty)
            places = {v.name: file[v.name].id.get_offset() or 0 for v in self.variables}
        return memory.getbuffer(), places


@lru_cache(maxsize=8)
def moulder(owner: str, subject: str, variables: tuple[Variable, ...], extents: tuple[tuple[str, int], ...]) -> Moulder:
    """Return what makes the moulds of these shards; the same one for the same shards."""
    return Moulder(owner, subject, variables, extents)
