"""Messages between this process and the reader of files from elsewhere: JSON and plain bytes, never pickles."""

from __future__ import annotations

import json
import socket
import struct
from typing import Any

LARGEST_CONTENT = 2**29  # bytes of all variables of a file from elsewhere
LARGEST_TEXT = 2**24  # bytes of JSON, all attributes together
_HEAD = struct.Struct("<QQ")  # bytes of JSON, and those behind it


class WireError(Exception):
    """The other end broke off, or does not speak as agreed."""


def send(connection: socket.socket, message: dict[str, Any], data: memoryview | bytes = b"") -> None:
    """Send a message and bytes behind it.

    Raises
    ------
    OSError
        If the other end is gone, or takes too long.
    """
    text = json.dumps(message).encode()
    connection.sendall(_HEAD.pack(len(text), len(data)) + text)
    connection.sendall(data)


def receive(connection: socket.socket, expected: int = 0) -> tuple[dict[str, Any], bytearray]:
    """Return a message and the bytes behind it, so many as are expected, or none.

    Raises
    ------
    WireError
        If anything else comes.
    OSError
        If it takes too long.
    """
    length, size = _HEAD.unpack(_bytes(connection, _HEAD.size))
    if length > LARGEST_TEXT or size not in (0, expected):
        raise WireError("a message is too long")
    try:
        message = json.loads(_bytes(connection, length))
    except (ValueError, RecursionError) as error:
        raise WireError("a message is no JSON") from error
    if not isinstance(message, dict):
        raise WireError("a message is no mapping")
    return message, _bytes(connection, size)


def _bytes(connection: socket.socket, size: int) -> bytearray:
    data = bytearray(size)
    view = memoryview(data)
    while view:
        got = connection.recv_into(view)
        if not got:
            raise WireError("the connection ended")
        view = view[got:]
    return data
