"""Giving memory back to the system."""

from __future__ import annotations

import contextlib
import ctypes


def release_memory() -> None:
    """Give back what was freed and what the C library's heaps keep all the same, where it can (glibc)."""
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)
