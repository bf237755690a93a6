"""The private cache folder where printed sources, derived programs and machine code lie."""

from __future__ import annotations

import atexit
import os
import shutil
import stat
import tempfile
from functools import cache
from pathlib import Path


@cache
def cache_folder() -> Path:
    """Return the private cache folder, made if needed.

    `QUAVSWEEP_CACHE`, else `quavsweep` in the user's cache folder; a temporary folder if that cannot be written or
    others could write there, because code is loaded from it.
    """
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(os.environ.get("QUAVSWEEP_CACHE") or Path(base) / "quavsweep")
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = folder.stat()
        if status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            with tempfile.TemporaryFile(dir=folder):
                return folder
    except OSError:
        pass
    private = Path(tempfile.mkdtemp(prefix="quavsweep-"))
    atexit.register(shutil.rmtree, private, ignore_errors=True)
    return private


def write_once(path: Path, text: str) -> None:
    """Write a file of the cache unless it is there with this content; never half a file."""
    try:
        if path.read_text() == text:
            return
    except (OSError, ValueError):
        pass
    handle, name = tempfile.mkstemp(dir=path.parent)
    with os.fdopen(handle, "w") as file:
        file.write(text)
    os.replace(name, path)
