"""HDF5's checksums of metadata, computed anew over mutated bytes, so that it is not they that save us."""

from __future__ import annotations

import re
import struct

_MASK = 0xFFFFFFFF
_BLOCK = re.compile(rb"\x89HDF\r\n\x1a\n|OHDR|OCHK|BTHD|BTIN|BTLF|FRHP|FHDB|FHIB|FSHD|FSSE|FAHD|FADB|EAHD|EAIB|EADB")
LONGEST = 700  # bytes of a block that is looked for


def _rotated(x: int, k: int) -> int:
    return ((x << k) | (x >> (32 - k))) & _MASK


def lookup3(data: bytes) -> int:
    """Return Bob Jenkins' hash, with which HDF5 checks metadata."""
    a = b = c = (0xDEADBEEF + len(data)) & _MASK
    padded = data + bytes(-len(data) % 12 if data else 12)
    words = struct.unpack(f"<{len(padded) // 4}I", padded)
    for i in range(0, len(words) - 3, 3):
        a, b, c = (a + words[i]) & _MASK, (b + words[i + 1]) & _MASK, (c + words[i + 2]) & _MASK
        for shift in (4, 6, 8, 16, 19, 4):
            a = ((a - c) & _MASK) ^ _rotated(c, shift)
            a, b, c = b, (c + b) & _MASK, a
    if data:
        a, b, c = (a + words[-3]) & _MASK, (b + words[-2]) & _MASK, (c + words[-1]) & _MASK
        for shift in (14, 11, 25, 16, 4, 14, 24):
            a, b, c = b, ((c ^ b) - _rotated(b, shift)) & _MASK, a
        c = b
    return c


def blocks(data: bytes) -> list[tuple[int, int]]:
    """Return begin and end of what checksums of a good file are about; a checksum stands at each end."""
    found = []
    for match in _BLOCK.finditer(data):
        begin = match.start()
        for end in range(begin + 8, min(begin + LONGEST, len(data) - 4)):
            if lookup3(data[begin:end]) == int.from_bytes(data[end : end + 4], "little"):
                found.append((begin, end))
                break
    return found


def renew(data: bytearray, where: list[tuple[int, int]], changed: list[int]) -> None:
    """Write the checksums of those blocks anew in which a byte was changed."""
    for begin, end in where:
        if end + 4 <= len(data) and any(begin <= offset < end for offset in changed):
            data[end : end + 4] = lookup3(bytes(data[begin:end])).to_bytes(4, "little")
