"""Clusters under attack: processes that `quavsweep run` starts itself, or a scheduler and workers of their own."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from tests.batch_cluster import batch_cluster
from tests.faults.arena import Arena, Victim
from tests.faults.subject import Subject

WORKERS = 3
# Tiles of one cell that take about half a second each; in large tiles, for a reference, it takes a tenth of the time.
CREW = """
name: {name}
model: lorenz
initial: {{x: 1.0, y: 1.0, z: 20.0}}
axes:
  rho: {{start: 0.5, stop: 620, num: {num}}}
integrate: {{method: rk4, dt: 0.02, transient: 10, duration: 24000}}
measures: {{lyapunov: {{exponents: 3, block: 5}}}}
effort: {{max_duration: 60000, of: [undecided, chaos]}}
"""
LARGE = Subject("crew", CREW.format(name="crew", num=28), 1)
SMALL = Subject("squad", CREW.format(name="squad", num=12), 1)


@dataclass(frozen=True)
class Site:
    """Where the workers of a run are: processes of the driver, or those of a cluster that is there already.

    Parameters
    ----------
    name : str
    arguments : tuple of str
        Of the command line.
    parent : int
        Number of the process that has the workers, 0 for the driver itself.
    """

    name: str
    arguments: tuple[str, ...]
    parent: int = 0

    def workers(self, victim: Victim) -> list[int]:
        """Return the numbers of the worker processes that live."""
        return children(self.parent or victim.pid)

    def start(self, arena: Arena, subject: Subject, place: Path, more: tuple[str, ...] = ()) -> Victim:
        """Start a run there."""
        return arena.start(subject, place, (*self.arguments, *more), prepare=have_children)


def whole(subject: Subject) -> Subject:
    """Return a sweep in one tile."""
    return replace(subject, tile_cells=64)


def have_children() -> None:
    """Let this process start processes; to be called in a victim."""
    multiprocessing.current_process().daemon = False


def local(workers: int = WORKERS) -> Site:
    """Return the site of a run that starts its workers itself."""
    return Site("processes", ("--processes", str(workers)))


@contextlib.contextmanager
def scheduled(folder: Path, workers: int = WORKERS) -> Iterator[Site]:
    """Give the site of a cluster whose nannies replace workers that die."""
    folder.mkdir()
    with batch_cluster(folder, {}, words=("--nworkers", str(workers))) as (file, running):
        yield Site("scheduler", ("--scheduler-file", str(file)), running[1].pid)


def children(parent: int) -> list[int]:
    """Return the worker processes that a process has."""
    found: list[int] = []
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{parent}/task").iterdir():
            found += map(int, (task / "children").read_text().split())
    return [pid for pid in found if b"spawn_main" in _told(pid, "cmdline")]


def has_kernel(pid: int) -> bool:
    """Whether a process has begun tiles: kernels are loaded for the first."""
    return b"llvmlite" in _told(pid, "maps")


def _told(pid: int, name: str) -> bytes:
    try:
        return Path(f"/proc/{pid}/{name}").read_bytes()
    except OSError:
        return b""


def send(pid: int, number: int) -> None:
    """Send a signal to a process that may be gone."""
    with contextlib.suppress(OSError):
        os.kill(pid, number)


def wait_for_shard(victim: Victim) -> None:
    """Wait until a run has published a shard, or ended."""
    while victim.code is None and not next((victim.folder / "run").glob("shards/*/*/*/tile-*"), None):
        time.sleep(0.02)
