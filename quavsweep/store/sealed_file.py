"""Reading result files: all bytes are checked once against the seal, then each variable is read when asked for."""

from __future__ import annotations

import contextlib
import os
import threading
import weakref
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from quavsweep.errors import DamageError, DiskError
from quavsweep.store.netcdf import DIGEST, attributes_of, content_digest, dims_of, read_values
from quavsweep.store.publish import PatientFile, is_sealed
from quavsweep.store.stored import Part, Stored, Variables

REBUILD = "run the sweep again to rebuild it"


class SealedFile:
    """An open result file whose bytes are those that were written.

    It stays open, so that a new result that takes its name changes nothing here. Should it be written to after the
    check, nothing more is read of it; and what the disk returns wrongly HDF5's own checksums show.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._reading = threading.Lock()
        with self._told():
            self._raw = path.open("rb")
            weakref.finalize(self, self._raw.close)
            self._written = self._stamp()
            if not is_sealed(self._raw):
                raise DamageError("its bytes are not those that were written", str(path), REBUILD)

    def _stamp(self) -> tuple[int, int]:
        """Return what changes when somebody writes into the file."""
        status = os.fstat(self._raw.fileno())
        return status.st_size, status.st_mtime_ns

    @contextlib.contextmanager
    def open(self) -> Iterator[h5py.File]:
        """Open the file with HDF5, for as long as the context lasts.

        Raises
        ------
        DamageError
            If it cannot be read, or was written to.
        """
        with self._reading, self._told():
            patient = PatientFile(self._raw)
            with h5py.File(patient, "r") as file:
                yield file
            if patient.error is not None:
                raise patient.error
            if self._stamp() != self._written:
                raise DamageError("was written to while it was read", str(self.path), REBUILD)

    def read(self, name: str, part: Part) -> np.ndarray:
        """Return a part of a variable.

        Raises
        ------
        DamageError
            As `open`.
        """
        with self.open() as file:
            return read_values(file[name], part)

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        """Tell whatever goes wrong with the file in a sentence."""
        try:
            yield
        except FileNotFoundError:
            raise
        except PermissionError as error:
            raise DiskError(f"cannot be read: {error.strerror}", str(self.path)) from error
        except (OSError, KeyError, ValueError, RuntimeError, TypeError, AttributeError, IndexError) as error:
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
    with sealed.open() as file:
        good = attributes_of(file).get(DIGEST) == content_digest(file)
    if not good:
        raise DamageError("its content is not what was written", str(path), REBUILD)
    return _stored(sealed)


def _stored(sealed: SealedFile) -> Stored:
    """Return the content of a file; variables are read when they are asked for."""
    with sealed.open() as file:
        names = tuple(sorted(file))
        return Stored(
            data=Variables(names, sealed.read),
            dims={name: dims_of(file, name) for name in names},
            attributes={name: attributes_of(file[name]) for name in names},
            file_attributes=attributes_of(file),
        )
