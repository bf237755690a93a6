"""A scheduler and workers as a batch system starts them: processes of their own, found by a file."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

PATIENCE = 30  # s, after which a worker gives up on a scheduler


@contextlib.contextmanager
def batch_cluster(
    folder: Path, *workers: dict[str, str], words: Sequence[str] = ("--no-nanny",), protocol: str = "tcp"
) -> Iterator[tuple[Path, list[subprocess.Popen[bytes]]]]:
    """Give the scheduler's file and the processes: the scheduler, then the workers.

    Parameters
    ----------
    folder : Path
        For their files.
    *workers : dict
        Variables of the environment of each worker.
    words : sequence of str
        More of the command that starts a worker.
    protocol : str
        The scheduler's, `tcp` or `tls`.
    """
    file = folder / "scheduler.json"
    running = [_start("dask_scheduler", [*_common(file), "--port", "0", "--protocol", protocol], {})]
    try:
        deadline = time.monotonic() + PATIENCE
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        for number, variables in enumerate(workers):
            running.append(start_worker(file, variables, ("--name", str(number), *words)))
        yield file, running
    finally:
        for process in running:
            with contextlib.suppress(OSError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def start_worker(file: Path, variables: dict[str, str], words: Sequence[str]) -> subprocess.Popen[bytes]:
    """Start a worker of the scheduler whose file that is, with variables of the environment."""
    own = ["--local-directory", str(file.parent / f"worker-{time.time_ns()}")]
    worker = ["--nthreads", "1", "--memory-limit", "0", "--death-timeout", str(PATIENCE), *own, *words]
    return _start("dask_worker", [*_common(file), *worker], variables)


def _common(file: Path) -> list[str]:
    return ["--scheduler-file", str(file), "--no-dashboard", "--host", "127.0.0.1"]


def _start(command: str, words: Sequence[str], variables: dict[str, str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.{command}", *words],
        env={**os.environ, **variables},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
