"""Files that appear whole and synced under their name, or not at all."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, TextIO

from quavsweep.errors import DiskError

TEMPORARY = ".quavsweep-"  # prefix of files in the making; what a killed process leaves behind


def publish_bytes(path: Path, data: bytes | memoryview) -> Path:
    """Write a small file whole or not at all.

    Raises
    ------
    DiskError
        If the disk is full, read-only or refuses; nothing is visible then.
    """
    with new_file(path.parent) as (raw, temporary):
        raw.write(data)
        raw.flush()
        reveal(raw, temporary, path)
    return path


@contextlib.contextmanager
def binary_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file that a user named, for writing; a device or a pipe is written to as it is.

    Raises
    ------
    DiskError
        If the folder is not there, or the disk is full, read-only or refuses.
    """
    target = Path(os.path.realpath(path))  # what a link leads to, not the link
    try:
        if is_special(target):
            with target.open("wb") as raw:
                yield raw
            return
        if target.is_dir() or not target.parent.is_dir():
            target.open("r+b").close()  # refuses in the system's words
        with new_file(target.parent) as (raw, temporary):
            yield raw
            raw.flush()
            reveal(raw, temporary, target)
    except OSError as error:
        raise DiskError(f"cannot be written: {error.strerror or error}", str(path)) from error


@contextlib.contextmanager
def text_file(path: Path) -> Iterator[TextIO]:
    """Open a text file that a user named, for writing, as `binary_file` does.

    Raises
    ------
    DiskError
        As `binary_file`.
    """
    with binary_file(path) as raw:
        text = io.TextIOWrapper(raw, encoding="utf-8", newline="", write_through=True)
        yield text
        text.detach()


def is_special(path: Path) -> bool:
    """Whether a device, a pipe or a socket lies there, of which no file can take the place."""
    return path.exists() and not (path.is_file() or path.is_dir())


@contextlib.contextmanager
def plain_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for reading that may come from elsewhere: a link is not followed, and a pipe not waited for.

    Raises
    ------
    OSError
        If it is no plain file, or cannot be opened.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, "is not a file", str(path))
    with os.fdopen(handle, "rb") as file:
        yield file


@contextlib.contextmanager
def new_file(folder: Path) -> Iterator[tuple[io.BufferedRandom, Path]]:
    """Open a temporary file in a folder; remove it if it was not revealed, and tell a disk's refusal as such."""
    temporary: Path | None = None
    try:
        make_folder(folder)
        handle, text = tempfile.mkstemp(prefix=f"{TEMPORARY}{os.getpid()}-", dir=folder)
        temporary = Path(text)
        with os.fdopen(handle, "w+b") as raw:
            yield raw, temporary
    except OSError as error:
        raise DiskError(f"cannot be written: {error.strerror or error}", str(folder)) from error
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)


def writer_lives(temporary: Path) -> bool:
    """Whether the process that is writing a temporary file is another one that lives on this machine."""
    number = temporary.name.removeprefix(TEMPORARY).partition("-")[0]
    return number.isdecimal() and int(number) != os.getpid() and Path(f"/proc/{number}").exists()


def reveal(raw: IO[bytes], temporary: Path, path: Path) -> None:
    """Sync a complete file, give it its name, and sync the folder so that the name survives a loss of power."""
    os.fchmod(raw.fileno(), 0o666 & ~_umask())
    os.fsync(raw.fileno())
    if path.is_dir():
        path.rename(path.with_name(f"{path.name}.bad"))
    os.replace(temporary, path)
    sync_folder(path.parent)


def make_folder(folder: Path) -> None:
    """Make a folder and its parents, and sync what holds them, so that they survive a loss of power."""
    if not folder.is_dir():
        make_folder(folder.parent)
        folder.mkdir(exist_ok=True)
        with contextlib.suppress(PermissionError):  # a folder may be written to and not read
            sync_folder(folder.parent)


def sync_folder(folder: Path) -> None:
    """Have the names in a folder survive a loss of power."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _umask() -> int:
    """Return the process's umask from /proc, because asking the system for it would change it under other threads."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("Umask:"):
                return int(line.split()[1], 8)
    except (OSError, ValueError):
        pass
    return 0o022
