"""The ledger of files that this installation has published, or the user trusts: HDF5 reads no other here."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from quavsweep.kernels.cache import cache_folder


def _ledger() -> Path:
    """Return where it lies: where nobody else can write."""
    return cache_folder() / "published"


def remember(sha256: str) -> None:
    """Add the SHA-256 of a file; one that cannot be added is read as any file from elsewhere."""
    if is_known(sha256):
        return
    with contextlib.suppress(OSError):
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        handle = os.open(_ledger(), flags, 0o600)
        try:
            os.write(handle, f"{sha256}\n".encode())
        finally:
            os.close(handle)


def is_known(sha256: str) -> bool:
    """Whether a file of this SHA-256, 64 digits, was published here."""
    with contextlib.suppress(OSError):
        return len(sha256) == 64 and f"{sha256}\n".encode() in _ledger().read_bytes()
    return False
