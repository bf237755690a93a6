"""The reader of files from elsewhere: a process of its own, in which HDF5 may crash, hang or want all memory.

`python -m quavsweep.store.reader SOCKET` waits for files and forks for each of them. What is forked can open no file
any more and has little memory and time; it refuses what results do not have, and answers with plain numbers.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import signal
import socket
import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from quavsweep.store.netcdf import attributes_of, content_digest, dims_of, read_values
from quavsweep.store.publish import PatientFile
from quavsweep.store.screen import RefusedContent, screen
from quavsweep.store.wire import WireError, receive, send

MEMORY = 768 * 2**20  # bytes on top of what the process has when it begins
SECONDS = 20  # of an answer, by the clock
PROCESSOR_SECONDS = 45  # of all answers about a file
LONGEST = 2**22  # characters of all texts of a variable
ENDS = (WireError, OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, MemoryError)


def main() -> None:
    """Fork for each file that comes, until nobody is left who could send one."""
    control = socket.socket(fileno=int(sys.argv[1]))
    _warm_up()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        _, handles, _, _ = socket.recv_fds(control, 1, 2)
        if len(handles) != 2:
            return
        with contextlib.suppress(OSError):
            if os.fork() == 0:
                control.close()
                _serve_and_end(*handles)
        for handle in handles:
            os.close(handle)


def _warm_up() -> None:
    """Use what reading uses once, because Python loads some of it from files that cannot be opened any more later."""
    with h5py.File(io.BytesIO(), "w") as file:
        file.create_dataset("word", data=np.array(["a"], dtype=object), dtype=h5py.string_dtype()).make_scale("word")
        file.create_dataset("number", data=np.zeros(1), chunks=(1,), compression="gzip", fletcher32=True, shuffle=True)
        file["number"].dims[0].attach_scale(file["word"])
        file.attrs["text"], file.attrs["bytes"] = "text", np.bytes_(b"text")
        screen(file)
        json.loads(json.dumps(_content(file)))
        content_digest(file)
        _answer(file, {"ask": "read", "name": "word", "part": []})


def _serve_and_end(file: int, connection: int) -> None:
    """Answer all questions about a file, and end without any clean-up that HDF5 might stumble over."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    try:
        _confine(max(file, connection))
        serve(file, socket.socket(fileno=connection))
    finally:
        os._exit(0)


def _confine(highest: int) -> None:
    """Give up the right to open and write files, to much memory and to much time."""
    pages = int(Path("/proc/self/statm").read_text().split()[0]) if Path("/proc/self/statm").exists() else 0
    memory = pages * resource.getpagesize() + MEMORY
    for limit, value in (
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_CPU, PROCESSOR_SECONDS),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, highest + 1),
    ):
        hard = resource.getrlimit(limit)[1]
        least = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(limit, (least, least))
    for handle in range(3, highest):  # no free number below the highest one is left, so nothing can be opened
        with contextlib.suppress(OSError):
            os.fstat(handle)
            continue
        os.dup2(0, handle)


def serve(file: int, connection: socket.socket) -> None:
    """Tell what there is in the file, then answer questions about it until the other end has no more."""
    with os.fdopen(file, "rb", closefd=False) as raw, contextlib.suppress(*ENDS):
        signal.alarm(SECONDS)
        try:
            with h5py.File(PatientFile(raw), "r", locking=False) as opened:
                screen(opened)
                send(connection, _content(opened))
                while True:
                    signal.alarm(0)
                    question, _ = receive(connection)
                    signal.alarm(SECONDS)
                    send(connection, *_answer(opened, question))
        except RefusedContent as refused:
            send(connection, {"refused": str(refused)})


def _answer(file: h5py.File, question: dict[str, Any]) -> tuple[dict[str, Any], memoryview | bytes]:
    """Return the answer to a question, and the bytes of numbers."""
    if question["ask"] == "digest":
        return {"digest": content_digest(file)}, b""
    part = tuple(p if isinstance(p, int) else slice(*p) for p in question["part"])
    values = read_values(file[question["name"]], part)
    if values.dtype.kind == "O":
        texts = [str(text) for text in values.ravel()]
        if sum(map(len, texts)) > LONGEST:
            raise RefusedContent("texts that are too long")
        return {"texts": texts}, b""
    flat = np.ascontiguousarray(values).reshape(-1)
    return {}, flat.view(np.uint8).data


def _content(file: h5py.File) -> dict[str, Any]:
    """Return what there is in a file: names, types, shapes, dimensions and attributes."""
    variables = {
        name: {
            "dtype": file[name].dtype.str,
            "shape": list(file[name].shape),
            "dims": list(_dims(file, name)),
            "attributes": _listed(file[name]),
        }
        for name in sorted(file)
    }
    return {"variables": variables, "attributes": _listed(file)}


def _dims(file: h5py.File, name: str) -> tuple[str, ...]:
    """Return the names of the dimensions of a dataset; none where it has no scales."""
    dataset = file[name]
    scaled = dataset.is_scale or all(len(dim) for dim in dataset.dims)
    return dims_of(file, name) if scaled else ()


def _listed(target: h5py.HLObject) -> dict[str, Any]:
    return {key: np.asarray(value).tolist() for key, value in attributes_of(target).items()}


if __name__ == "__main__":
    main()
