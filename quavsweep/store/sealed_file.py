"""Reading result files: all bytes are checked once against the seal, then each variable is read when asked for.

HDF5 reads in this process only what this installation has published; the rest is read by another process, and must be
made as a result of its own config is.
"""

from __future__ import annotations

import contextlib
import os
import threading
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import h5py
import numpy as np

from quavsweep.errors import PASSING_ERRNOS, ConfigError, DamageError, DiskError
from quavsweep.store.foreign import TRUST, ForeignFile
from quavsweep.store.ledger import is_known
from quavsweep.store.netcdf import DIGEST, attributes_of, content_digest, dims_of, read_values
from quavsweep.store.publish import PatientFile, is_sealed, seal_digest
from quavsweep.store.stored import Part, Stored, Variables
from quavsweep.whole import is_special

REBUILD = "run the sweep again to rebuild it"
LARGEST = 2**31  # bytes of a file from elsewhere
READING = (OSError, RuntimeError)  # what HDF5 raises where it cannot read
BROKEN = (*READING, KeyError, ValueError, TypeError, AttributeError, IndexError)  # and what follows from lost structure


def _close(raw: IO[bytes]) -> None:
    """Close a file of which nobody wants to know any more; it was only read."""
    with contextlib.suppress(OSError):
        raw.close()


class SealedFile:
    """An open result file whose bytes are those that were written.

    It stays open, so that a new result that takes its name changes nothing here. Should it be written to after the
    check, nothing more is read of it; and what the disk returns wrongly HDF5's own checksums show.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._reading = threading.Lock()
        if is_special(path):  # a pipe would be waited for
            raise DamageError("is not a file", str(path), REBUILD)
        with self._told():
            self._raw = path.open("rb")
            weakref.finalize(self, _close, self._raw)
            self._written = self._stamp()
            known = is_known(seal_digest(self._raw))
            if not known and self._written[0] > LARGEST:
                raise ConfigError("is too large for a file from elsewhere", str(path), TRUST)
            if not is_sealed(self._raw):
                raise DamageError("its bytes are not those that were written", str(path), REBUILD)
        self.foreign = None if known else ForeignFile(self._raw, str(path))

    def _stamp(self) -> tuple[int, int]:
        """Return what changes when somebody writes into the file."""
        status = os.fstat(self._raw.fileno())
        return status.st_size, status.st_mtime_ns

    @contextlib.contextmanager
    def open(self) -> Iterator[h5py.File]:
        """Open the file with HDF5, for as long as the context lasts; mistakes of those who read it stay what they are.

        Raises
        ------
        DamageError
            If it cannot be read, or was written to.
        """
        with self._reading:
            patient = PatientFile(self._raw)
            with self._told():
                file = h5py.File(patient, "r")
            with self._told(READING):
                try:
                    with file:
                        yield file
                finally:
                    self._check(patient)

    def _check(self, patient: PatientFile) -> None:
        """Raise what went wrong with the bytes, whatever it led to."""
        if patient.error is not None:
            raise patient.error
        if self._stamp() != self._written:
            raise DamageError("was written to while it was read", str(self.path), REBUILD)

    @contextlib.contextmanager
    def content(self) -> Iterator[h5py.File]:
        """Open the file, as `open` does, to read all that it holds; whatever goes wrong then is damage."""
        with self._told(), self.open() as file:
            yield file

    def read(self, name: str, part: Part) -> np.ndarray:
        """Return a part of a variable.

        Raises
        ------
        DamageError
            As `open`.
        """
        if self.foreign is not None:
            return self.foreign.read(name, part)
        with self.open() as file:
            with self._told():
                dataset = file[name]
            return read_values(dataset, part)

    @contextlib.contextmanager
    def _told(self, errors: tuple[type[Exception], ...] = BROKEN) -> Iterator[None]:
        """Tell what goes wrong with the file in a sentence."""
        try:
            yield
        except FileNotFoundError:
            raise
        except errors as error:
            if isinstance(error, PermissionError) or (isinstance(error, OSError) and error.errno in PASSING_ERRNOS):
                raise DiskError(f"cannot be read: {error.strerror}", str(self.path)) from error
            raise DamageError("cannot be read as a result file", str(self.path), REBUILD) from error


def read_result(path: Path) -> Stored:
    """Return a result file's content after the file has been verified; variables are read when they are asked for.

    Raises
    ------
    DamageError
        If its content is not what was written.
    DiskError
        If it may not be read.
    """
    return _stored(SealedFile(path))


def check_result(path: Path) -> Stored:
    """Return a result file's content after the digest of all variables and attributes has been checked, too.

    Raises
    ------
    DamageError, DiskError
        As `read_result`.
    """
    sealed = SealedFile(path)
    if sealed.foreign is not None:
        good = sealed.foreign.attributes.get(DIGEST) == sealed.foreign.digest()
    else:
        with sealed.content() as file:
            good = attributes_of(file).get(DIGEST) == content_digest(file)
    if not good:
        raise DamageError("its content is not what was written", str(path), REBUILD)
    return _stored(sealed)


def _stored(sealed: SealedFile) -> Stored:
    """Return the content of a file; variables are read when they are asked for."""
    if sealed.foreign is not None:
        from quavsweep.store.fit import fitted  # what a file that was made here need not load

        return fitted(sealed.foreign, sealed.path)
    with sealed.content() as file:
        names = tuple(sorted(file))
        return Stored(
            data=Variables(names, sealed.read),
            dims={name: dims_of(file, name) for name in names},
            attributes={name: attributes_of(file[name]) for name in names},
            file_attributes=attributes_of(file),
        )
