"""Errors and kills at chosen system calls, by strace, of a process that waits at its gate."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.faults.arena import Victim
from tests.faults.fault import NotRunError

CALLS = ("openat", "write", "fsync", "close", "rename", "mkdir", "unlink", "fchmod", "lseek", "ftruncate")


@contextmanager
def traced(victim: Victim, *options: str, log: Path = Path("/dev/null")) -> Iterator[None]:
    """Attach strace to a process at its gate, let it go on, and detach after its end.

    Raises
    ------
    NotRunError
        If there is no strace, or it may not trace.
    """
    program = shutil.which("strace")
    if program is None:
        victim.send(signal.SIGKILL)
        raise NotRunError("strace is not installed (Debian's package strace)")
    victim.wait_until_stopped()
    command = [program, "-f", "-qq", "-o", str(log), "-p", str(victim.pid), *options]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as tracer:
        while not _is_traced(victim):
            if tracer.poll() is not None:
                victim.send(signal.SIGKILL)
                raise NotRunError(f"strace cannot trace: {tracer.stderr.read().strip()}")  # type: ignore[union-attr]
            time.sleep(0.002)
        victim.send(signal.SIGCONT)
        try:
            yield
        finally:
            victim.wait()


def _is_traced(victim: Victim) -> bool:
    status = Path(f"/proc/{victim.pid}/status").read_text()
    return re.search(r"^TracerPid:\s+0$", status, re.MULTILINE) is None


def counted(victim: Victim, log: Path) -> Counter[str]:
    """Return how often the thread that does it most often makes each call, in a process that nothing befalls."""
    with traced(victim, "-e", f"trace={','.join(CALLS)}", log=log):
        victim.wait()
    calls = Counter(re.findall(r"^(\d+) +(\w+)\(", log.read_text(), re.MULTILINE))
    most = Counter[str]()
    for (_, call), n in calls.items():
        most[call] = max(most[call], n)
    return most


def inject(call: str, what: str, when: str) -> tuple[str, ...]:
    """Return the options that let the call of that number in each thread fail, or end in a signal."""
    return "-e", f"trace={call}", "-e", f"inject={call}:{what}:when={when}"
