"""Mutants of a valid result whose checksums, digest and seal are computed anew, as a hostile person would."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from quavsweep.errors import DamageError
from quavsweep.store.foreign import ForeignFile
from quavsweep.store.netcdf import DIGEST
from quavsweep.store.publish import _SEAL
from tests.faults.checksum import blocks, renew

SEAL = len(_SEAL % bytes(64))
ODD = (0, 1, 2**7, 2**8 - 1, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
METADATA = 0.7  # share of the mutations that hit what HDF5 parses


def sealed(data: bytes) -> bytes:
    """Return the bytes of a file with a seal that fits."""
    return bytes(data) + _SEAL % hashlib.sha256(data).hexdigest().encode()


class Mutants:
    """Makes mutants of the bytes of one result file."""

    def __init__(self, result: bytes, rng: np.random.Generator) -> None:
        self.good, self.rng = result[:-SEAL], rng
        self.blocks = blocks(self.good)
        begin = self.good.find(DIGEST.encode())
        self.digest = next(i for i in range(begin, begin + 200) if self._is_digest(self.good[i : i + 64]))

    @staticmethod
    def _is_digest(text: bytes) -> bool:
        return len(text) == 64 and all(c in b"0123456789abcdef" for c in text)

    def _offset(self, length: int) -> int:
        """Return where to mutate: mostly inside a block that HDF5 parses."""
        if self.rng.random() < METADATA:
            begin, end = self.blocks[self.rng.integers(len(self.blocks))]
            return min(int(self.rng.integers(begin, end)), len(self.good) - length)
        return int(self.rng.integers(len(self.good) - length))

    def flip(self, data: bytearray) -> list[int]:
        """Flip some bits."""
        changed = [self._offset(1) for _ in range(self.rng.integers(1, 5))]
        for offset in changed:
            data[offset] ^= 1 << int(self.rng.integers(8))
        return changed

    def number(self, data: bytearray) -> list[int]:
        """Put odd numbers in the place of others."""
        length = int(self.rng.choice([1, 2, 4, 8]))
        offset, value = self._offset(length), ODD[self.rng.integers(len(ODD))] % 2 ** (8 * length)
        data[offset : offset + length] = value.to_bytes(length, "little")
        return [*range(offset, offset + length)]

    def splice(self, data: bytearray) -> list[int]:
        """Put bytes of one place in another."""
        length = int(self.rng.integers(1, 64))
        source, target = self._offset(length), self._offset(length)
        data[target : target + length] = self.good[source : source + length]
        return [*range(target, target + length)]

    def cut(self, data: bytearray) -> list[int]:
        """Cut the end off, or bytes out of the middle, or put some in."""
        kind, offset = self.rng.integers(3), int(self.rng.integers(len(data)))
        if kind == 0:
            del data[offset:]
        elif kind == 1:
            del data[offset : offset + int(self.rng.integers(1, 64))]
        else:
            data[offset:offset] = self.rng.bytes(int(self.rng.integers(1, 64)))
        return []

    def make(self, digest: bool = True) -> tuple[str, bytes]:
        """Return what was done and the bytes of a sealed mutant, with the digest of its content if wanted."""
        ways: list[Callable[[bytearray], list[int]]] = [self.flip, self.number, self.splice, self.cut]
        way = ways[self.rng.choice(len(ways), p=[0.35, 0.35, 0.2, 0.1])]
        data = bytearray(self.good)
        changed = way(data)
        renew(data, self.blocks if changed else [], changed)
        if digest:
            self._digest_anew(data)
        return way.__name__, sealed(bytes(data))

    def _digest_anew(self, data: bytearray) -> None:
        """Write the digest of the content that the mutant has, if it has any."""
        if not self._is_digest(bytes(data[self.digest : self.digest + 64])):
            return
        with tempfile.TemporaryFile() as file:
            file.write(data)
            try:
                digest = ForeignFile(file, "mutant").digest()
            except DamageError:
                return
        data[self.digest : self.digest + 64] = digest.encode()
        renew(data, self.blocks, [self.digest])


def small_result(folder: Path) -> bytes:
    """Return the bytes of a small result."""
    from quavsweep.config import parse_sweep  # noqa: PLC0415
    from quavsweep.sweep import run_sweep  # noqa: PLC0415
    from tests.conftest import YAW  # noqa: PLC0415

    text = YAW.replace("num: 9", "num: 3").replace("num: 5}", "num: 2}").replace("transient: 200", "transient: 20")
    return run_sweep(parse_sweep(text.replace("duration: 600", "duration: 60")), folder).read_bytes()
