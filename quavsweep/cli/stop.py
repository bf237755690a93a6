"""Ctrl-C, SIGTERM, SIGHUP, SIGUSR1 and the end of the time end a run within two seconds, whatever it is doing."""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
from collections.abc import Callable
from functools import partial
from typing import NoReturn

from quavsweep.cli.text import EXIT_SECOND_INTERRUPT, warn
from quavsweep.errors import STOPPED, StoppedError
from quavsweep.will import execute

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1)
GRACE = 1.0  # s, in which a run ends by itself; a kernel that is compiled, a large tile and a dead cluster take longer
LAST_WORDS = 0.3  # s, in which the record of a run may be written that did not end in time
_TIME_OVER = 0  # told in place of a signal's number
_SHOW_CURSOR = "\x1b[?25h"


def stop_on_signals(max_time: float | None, again: str = "continues it") -> threading.Event:
    """Return an event that a signal or the end of the time sets; a second Ctrl-C ends it all.

    What has not ended by itself `GRACE` later is ended: nothing is lost by that but the tiles in flight.

    Parameters
    ----------
    max_time : float or None
        Time until then [s].
    again : str
        What the same command does afterwards.
    """
    stop = threading.Event()
    hears, tells = os.pipe()
    os.set_blocking(tells, False)
    signal.set_wakeup_fd(tells, warn_on_full_buffer=False)
    os.register_at_fork(after_in_child=partial(signal.set_wakeup_fd, -1))
    for number in SIGNALS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # as nohup wants it
            signal.signal(number, _leave_to_listener)
    atexit.register(_ignore_signals)
    # A thread of its own hears of signals while the main thread is in a compiler or a library.
    threading.Thread(
        target=_listen, args=(hears, stop, partial(_end, again)), name="quavsweep-stop", daemon=True
    ).start()
    if max_time is not None:
        _later(max_time, partial(os.write, tells, bytes([_TIME_OVER])))
    return stop


def leave(code: int) -> NoReturn:
    """End the process, which has printed all; a stopped run at once, without taking its interpreter apart."""
    if code == StoppedError.exit_code and signal.getsignal(signal.SIGTERM) is _leave_to_listener:
        os._exit(code)
    sys.exit(code)


def _leave_to_listener(number: int, frame: object) -> None:
    """Do nothing: the number has been written into the pipe already."""


def _ignore_signals() -> None:
    """Let no signal spoil the exit code of a process that is about to end."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def _listen(hears: int, stop: threading.Event, end: Callable[[], None]) -> None:
    """Set the event at the first signal, and see to it that the process ends."""
    while told := os.read(hears, 1):
        if told[0] not in (*SIGNALS, _TIME_OVER):
            continue
        if not stop.is_set():
            stop.set()
            _later(GRACE, end)
        elif told[0] == signal.SIGINT:
            _exit(EXIT_SECOND_INTERRUPT)


def _later(seconds: float, function: Callable[[], object]) -> None:
    timer = threading.Timer(seconds, function)
    timer.daemon = True
    timer.start()


def _end(again: str) -> None:
    """End a run that does not end by itself."""
    warn(f"quavsweep: {StoppedError(STOPPED, possible=f'the same command {again}')}")
    execute(LAST_WORDS)
    _exit(StoppedError.exit_code)


def _exit(code: int) -> None:
    if sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write(_SHOW_CURSOR)
        sys.stderr.flush()
    os._exit(code)
