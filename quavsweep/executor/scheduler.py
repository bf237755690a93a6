"""Joining the scheduler of a cluster: its address, whether it may be talked to, and for how long it is waited for."""

from __future__ import annotations

import json
import queue
import threading
import time
from pathlib import Path
from urllib.parse import urlsplit

import distributed
from distributed.comm.core import FatalCommClosedError

from quavsweep.errors import STOPPED, ConfigError, StoppedError

LOCAL = ("127.0.0.1", "localhost", "::1")
CONNECT_SECONDS = 20.0  # an unreachable scheduler is told within 30 s
_TLS = "ca-file, client.cert and client.key below distributed.comm.tls of dask's config"


def check_address(address: str, insecure: bool) -> None:
    """Refuse what is not the address of a scheduler, or one of another machine without TLS.

    Raises
    ------
    ConfigError
        With what is possible; also if the certificates for TLS are missing or cannot be used.
    """
    try:
        parts = urlsplit(address)
        good = parts.scheme in ("tcp", "tls") and parts.hostname and parts.port
    except ValueError:
        good = False
    if not good:
        raise ConfigError("is not the address of a scheduler", address, "tcp://HOST:PORT or tls://HOST:PORT")
    if parts.scheme == "tcp" and parts.hostname not in LOCAL and not insecure:
        what = "a scheduler on another machine is talked to without encryption, and what it sends is executed"
        raise ConfigError(what, address, "tls://, or --insecure in a network that you trust")
    if parts.scheme == "tls":
        try:
            context = distributed.Security().get_connection_args("client").get("ssl_context")
        except OSError as error:  # ssl's errors are some
            raise ConfigError(f"its certificates cannot be used ({error})", address, f"see {_TLS}") from error
        if context is None:
            raise ConfigError("cannot be talked to, because dask's config names no certificates", address, _TLS)


def join(address: str, file: Path | None, insecure: bool, stop: threading.Event) -> distributed.Client:
    """Return a client of a scheduler, which is named by its address or by the file that it writes.

    Raises
    ------
    ConfigError
        If what is named is no scheduler, or may not be talked to.
    StoppedError
        If no scheduler answers in time, or `stop` is set.
    """
    deadline = time.monotonic() + CONNECT_SECONDS
    if file is not None:
        address = _told_address(file, deadline, stop)
        check_address(address, insecure)
    answer: queue.Queue[distributed.Client | Exception] = queue.Queue()

    def connect() -> None:
        try:
            answer.put(distributed.Client(address=address, timeout=CONNECT_SECONDS))
        except Exception as error:
            answer.put(error)

    # Its own timeout ends with the connection: what takes that and says nothing would be waited for without end.
    threading.Thread(target=connect, name="quavsweep-join", daemon=True).start()
    while time.monotonic() < deadline + 1.0:
        _give_way(stop)
        try:
            found = answer.get(timeout=0.1)
        except queue.Empty:
            continue
        if isinstance(found, distributed.Client):
            return found
        raise _explained(found, address) from None
    raise _explained(TimeoutError("it says nothing"), address)


def _explained(error: Exception, address: str) -> ConfigError | StoppedError:
    """Return what it means that nobody could be talked to."""
    if isinstance(error, FatalCommClosedError):
        return ConfigError(f"it cannot be talked to ({error})", address, f"see {_TLS}")
    if isinstance(error, OSError):  # a TimeoutError is one
        return StoppedError(f"no scheduler answers ({error})", address, "start it and run the same command")
    return ConfigError(f"what answers is no scheduler of dask ({type(error).__name__}: {error})", address)


def _told_address(file: Path, deadline: float, stop: threading.Event) -> str:
    """Return the address in the file of a scheduler, which may be starting still and have written none."""
    while True:
        _give_way(stop)
        try:
            return str(json.loads(file.read_text())["address"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            if time.monotonic() < deadline:
                time.sleep(0.1)
                continue
            if isinstance(error, FileNotFoundError):
                what = "no scheduler has written this file"
                raise StoppedError(what, str(file), "start it and run the same command") from None
            raise ConfigError(f"is not the file of a scheduler ({error})", str(file)) from None


def _give_way(stop: threading.Event) -> None:
    if stop.is_set():
        raise StoppedError(STOPPED)
