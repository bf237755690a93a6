"""Files from elsewhere: a process of its own reads them, and nothing that it says is believed unchecked."""

from __future__ import annotations

import contextlib
import math
import os
import re
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

import quavsweep
from quavsweep.errors import DamageError, DiskError
from quavsweep.store.screen import LARGEST_RANK, NAME
from quavsweep.store.stored import Part
from quavsweep.store.wire import LARGEST_CONTENT, WireError, receive, send

SECONDS = 25  # of an answer; the reader gives up a little earlier by itself
ALL_SECONDS = 45  # of all answers about a file
ELSEWHERE = "a file from elsewhere is read only if it is made as quavsweep makes them"
TRUST = "if you know who made it, quavsweep verify DIR --trust lifts the limits"
_TYPES = re.compile(r"\|[iu]1|<[iu][248]|<f[248]")
_ALONE = {
    "HDF5_PLUGIN_PATH": "",
    "HDF5_PLUGIN_PRELOAD": "::",  # no filters from elsewhere
    "HDF5_USE_FILE_LOCKING": "FALSE",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
}
_starting = threading.Lock()
_forks: list[tuple[socket.socket, subprocess.Popen[bytes]]] = []  # the one process that forks readers, if it runs


@dataclass(frozen=True)
class Content:
    """What a file holds of a variable: type (empty for texts), shape, dimensions and attributes."""

    dtype: str
    shape: tuple[int, ...]
    dims: tuple[str, ...]
    attributes: dict[str, Any]


class ForeignFile:
    """A file that another process reads.

    Parameters
    ----------
    raw : binary file
        Open; its position moves.
    where : str
        Its name in errors.

    Raises
    ------
    DamageError
        If it is not made as quavsweep makes files, or its reader broke.
    DiskError
        If there can be no other process.
    """

    def __init__(self, raw: IO[bytes], where: str) -> None:
        self.where = where
        self._asking, self._left = threading.Lock(), float(ALL_SECONDS)
        self._connection = self._connect(raw)
        with self._told():
            message, _ = self._receive(0)
            self.attributes = _attributes(message["attributes"])
            self.variables = {name: _variable(name, told) for name, told in message["variables"].items()}
            size = sum(math.prod(v.shape) * np.dtype(v.dtype or "O").itemsize for v in self.variables.values())
            if size > LARGEST_CONTENT:
                raise WireError("too much")

    def _connect(self, raw: IO[bytes]) -> socket.socket:
        mine, theirs = socket.socketpair()
        with theirs:
            try:
                _hand_over([raw.fileno(), theirs.fileno()])
            except OSError as error:
                raise DiskError(f"no process can be started to read it: {error.strerror}", self.where) from error
        return mine

    def _receive(self, expected: int) -> tuple[dict[str, Any], bytearray]:
        """Return an answer that comes in time."""
        begun = time.monotonic()
        self._connection.settimeout(max(0.01, min(SECONDS, self._left)))
        message, data = receive(self._connection, expected)
        self._left -= time.monotonic() - begun
        if "refused" in message:
            what = "".join(c for c in str(message["refused"])[:200] if c.isprintable())
            raise DamageError(f"holds {what}", self.where, ELSEWHERE)
        return message, data

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        """Tell in a sentence that the reader broke; nothing more is asked of it."""
        try:
            yield
        except (WireError, OSError, LookupError, ValueError, TypeError, AttributeError, OverflowError) as error:
            self._connection.close()
            raise DamageError("cannot be read: its reader broke or took too long", self.where, ELSEWHERE) from error

    def read(self, name: str, part: Part = ()) -> np.ndarray:
        """Return a part of a variable.

        Raises
        ------
        DamageError
            If the reader broke.
        """
        variable = self.variables[name]
        dtype = np.dtype(variable.dtype or "O")
        shape = np.broadcast_to(np.empty((), dtype), variable.shape)[part].shape
        asked = [[p.start, p.stop, p.step] if isinstance(p, slice) else int(p) for p in part]
        with self._asking, self._told():
            send(self._connection, {"ask": "read", "name": name, "part": asked})
            count = math.prod(shape)
            if not variable.dtype:
                texts = self._receive(0)[0]["texts"]
                if len(texts) != count or not all(isinstance(text, str) for text in texts):
                    raise WireError("other texts")
                return np.array([*texts, None], dtype=object)[:-1].reshape(shape)
            data = self._receive(count * dtype.itemsize)[1]
            return np.frombuffer(data, dtype=dtype, count=count).reshape(shape)

    def digest(self) -> str:
        """Return the digest of all that is in the file.

        Raises
        ------
        DamageError
            If the reader broke.
        """
        with self._asking, self._told():
            send(self._connection, {"ask": "digest"})
            return str(self._receive(0)[0]["digest"])


def _attributes(told: Any) -> dict[str, Any]:
    """Return attributes, lists as arrays, after a check that they are plain."""
    found = {}
    for key, value in told.items():
        items = value if isinstance(value, list) else [value]
        if not all(isinstance(item, str | int | float) for item in items):
            raise WireError("an odd attribute")
        found[str(key)] = np.array(value) if isinstance(value, list) else value
    return found


def _variable(name: str, told: Any) -> Content:
    """Return what is told of a variable after a check that it can be."""
    shape, dims = tuple(told["shape"]), tuple(told["dims"])
    dtype = "" if told["dtype"] == "|O" else told["dtype"]
    good = NAME.fullmatch(name) and (not dtype or _TYPES.fullmatch(dtype)) and len(shape) <= LARGEST_RANK
    if not good or not all(isinstance(n, int) and n >= 0 for n in shape) or not all(map(NAME.fullmatch, dims)):
        raise WireError("an odd variable")
    return Content(dtype, shape, dims, _attributes(told["attributes"]))


def _hand_over(handles: list[int]) -> None:
    """Send open files to the process that forks a reader for them; it is started when it is first needed."""
    with _starting:
        if _forks and _forks[0][1].poll() is not None:  # it was killed
            _forks.pop()[0].close()
        if not _forks:
            _forks.append(_start())
        socket.send_fds(_forks[0][0], [b"f"], handles)


def _start() -> tuple[socket.socket, subprocess.Popen[bytes]]:
    """Start that process; it ends with the last process that could ask it."""
    mine, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    root = str(Path(quavsweep.__file__).parents[1])
    paths = os.pathsep.join(dict.fromkeys([root, *filter(None, sys.path)]))
    with theirs:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "quavsweep.store.reader", str(theirs.fileno())],
            env={**os.environ, **_ALONE, "PYTHONPATH": paths},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        )
    return mine, process
