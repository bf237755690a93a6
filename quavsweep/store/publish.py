"""Publishing an HDF5 file: whole and synced under its name, or not at all; and its seal."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import h5py

from quavsweep.store.ledger import remember
from quavsweep.whole import new_file, publish_bytes, reveal

_HDF5 = b"\x89HDF\r\n\x1a\n"
_SEAL = b"quavsweep sha256 %s\n"  # appended to a file that is not named by its digest


class PatientFile:
    """A binary file for HDF5 that never fails: the first OSError is remembered, and what follows is swallowed.

    An exception on its way through HDF5's own clean-up ends in a crash of the interpreter; the file is discarded
    instead once HDF5 is done with it.
    """

    def __init__(self, file: IO[bytes]) -> None:
        self.file = file
        self.error: OSError | None = None

    def _try(self, call: Callable[..., Any], *arguments: Any, default: Any = None) -> Any:
        if self.error is None:
            try:
                return call(*arguments)
            except OSError as error:
                self.error = error
        return default

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to an offset."""
        return int(self._try(self.file.seek, offset, whence, default=0))

    def tell(self) -> int:
        """Return the offset."""
        return int(self._try(self.file.tell, default=0))

    def write(self, data: Any) -> int:
        """Write bytes and say that all were written."""
        view = memoryview(data).cast("B")
        done = 0
        while done < len(view) and self.error is None:
            done += self._try(self.file.write, view[done:], default=0)
        return len(view)

    def read(self, size: int = -1) -> bytes:
        """Read bytes."""
        return bytes(self._try(self.file.read, size, default=b""))

    def readinto(self, buffer: Any) -> int:
        """Read bytes into a buffer."""
        return int(self._try(self.file.readinto, buffer, default=0))  # type: ignore[attr-defined]

    def truncate(self, size: int | None = None) -> int:
        """Cut or lengthen the file."""
        return int(self._try(self.file.truncate, size, default=0))

    def flush(self) -> None:
        """Hand written bytes to the system."""
        self._try(self.file.flush)


_held: list[int] = []  # Ctrl-C that waits


@contextlib.contextmanager
def _holding_interrupts() -> Iterator[None]:
    """Hold Ctrl-C back in the main thread, where it would be an exception on its way through HDF5."""
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    _held.clear()
    signal.signal(signal.SIGINT, lambda number, frame: _held.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    give_way()


def give_way() -> None:
    """Raise the Ctrl-C that is held back, between calls of HDF5 that take long together.

    Raises
    ------
    KeyboardInterrupt
        If there is one.
    """
    if _held and threading.current_thread() is threading.main_thread():
        _held.clear()
        raise KeyboardInterrupt


def publish_hdf5(name: Callable[[str, int], Path], write: Callable[[h5py.File], None], *, in_memory: bool) -> Path:
    """Write an HDF5 file and give it its name once it is complete and synced.

    Parameters
    ----------
    name : callable
        From SHA-256 and size in bytes to the path.
    write : callable
        Fills the open file.
    in_memory : bool
        Whether the file is small enough to be built in memory; if not, it ends with a seal, see `is_sealed`.

    Raises
    ------
    DiskError
        If the disk is full, read-only or refuses; nothing is visible then.
    """
    folder = name("0", 0).parent
    if in_memory:
        memory = io.BytesIO()
        with h5py.File(memory, "w", libver=("v110", "v110")) as file:
            write(file)
        with memory.getbuffer() as data:
            return publish_bytes(name(hashlib.sha256(data).hexdigest(), len(data)), data)
    with new_file(folder) as (raw, temporary):
        patient = PatientFile(raw)
        with _holding_interrupts(), h5py.File(patient, "w", libver=("v110", "v110")) as file:
            write(file)
        if patient.error is not None:
            raise patient.error
        raw.flush()
        raw.seek(0)
        sha256 = hashlib.file_digest(raw, "sha256").hexdigest()
        raw.seek(0, os.SEEK_END)
        raw.write(_SEAL % sha256.encode())
        raw.flush()
        path = name(sha256, raw.tell())
        remember(sha256)
        reveal(raw, temporary, path)
    return path


def looks_published(path: Path) -> bool:
    """Whether a file begins as HDF5 or ends as a seal, so that it may be a result, damaged or not."""
    with path.open("rb") as file:
        begin = file.read(len(_HDF5))
        file.seek(-min(file.seek(0, os.SEEK_END), len(_SEAL % bytes(64))), os.SEEK_END)
        return begin == _HDF5 or file.read().startswith(_SEAL.partition(b"%")[0])


def seal_digest(file: IO[bytes]) -> str:
    """Return the SHA-256 that the seal of an open file names, empty if there is no seal; nothing is checked.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    begin = _SEAL.partition(b"%")[0]
    file.seek(-min(file.seek(0, os.SEEK_END), len(_SEAL % bytes(64))), os.SEEK_END)
    end = file.read(len(_SEAL % bytes(64)))
    return end.removeprefix(begin).strip().decode("ascii", "replace") if end.startswith(begin) else ""


def is_sealed(file: IO[bytes]) -> bool:
    """Whether an open file ends with a seal that fits all bytes before it.

    HDF5 does not look beyond the end that its superblock names, so a seal does not disturb other readers; and it is
    checked before HDF5 sees the file, so that damage to structure is seen too and never parsed.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    left = file.seek(0, os.SEEK_END) - len(_SEAL % bytes(64))
    if left < 0:
        return False
    file.seek(0)
    digest = hashlib.sha256()
    while left and (data := file.read(min(left, 2**20))):
        digest.update(data)
        left -= len(data)
    return file.read(len(_SEAL % bytes(64)) + 1) == _SEAL % digest.hexdigest().encode()
