"""The private cache folder where printed sources, derived programs and machine code lie."""

from __future__ import annotations

import atexit
import contextlib
import hashlib
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


def write_sealed(path: Path, text: str) -> None:
    """Write a file of the cache as `write_once` does, with a digest below the text."""
    write_once(path, f"{text}\n{_digest(text.encode())}\n")


def read_sealed(path: Path) -> str:
    """Return the text of a file that `write_sealed` wrote.

    Raises
    ------
    ValueError
        If it is not what was written.
    OSError
        If it cannot be read.
    """
    text, _, digest = path.read_text().removesuffix("\n").rpartition("\n")
    if _digest(text.encode()) != digest:
        raise ValueError(f"{path} is not what was written")
    return text


def seal_machine_code(source: Path) -> None:
    """Remember the bytes of the machine code that lies in the cache beside its source."""
    with contextlib.suppress(OSError):
        write_once(source.with_suffix(".seal"), _machine_code(source))


def check_machine_code(source: Path) -> None:
    """Discard machine code whose bytes are not those that were sealed: it would be run as it is."""
    with contextlib.suppress(OSError, ValueError):
        if source.with_suffix(".seal").read_text() == _machine_code(source):
            return
    discard_machine_code(source)


def discard_machine_code(source: Path) -> None:
    """Remove the machine code of a source; it is made again when it is loaded."""
    for path in source.parent.glob(f"__pycache__/{source.stem}.*"):
        path.unlink(missing_ok=True)


def _machine_code(source: Path) -> str:
    """Return a line of name and digest for each file of machine code."""
    paths = sorted(source.parent.glob(f"__pycache__/{source.stem}.*"))
    return "".join(f"{path.name} {_digest(path.read_bytes())}\n" for path in paths)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
