"""F36: neither memory nor descriptors grow over ten thousand tiles, in the driver or in its workers."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.faults.arena import Arena, Victim
from tests.faults.crew import Site, local
from tests.faults.fault import Case, Fault
from tests.faults.subject import QUICK, Subject

TILES = 10_000
WARM = 500  # tiles after which everything is loaded that ever will be
MOST = 50e6  # bytes
WINDOW = 500  # tiles, whose median is taken of what comes and goes
SUBJECT = Subject("leak", QUICK.replace("name: quick", "name: leak").replace("num: 16", f"num: {TILES}"), 1)
SITES = (Site("threads", ("--workers", "2")), local(2))


@dataclass
class Process:
    """What a process held while tiles were done.

    Parameters
    ----------
    samples : list of tuple
        Tiles done, resident bytes, open descriptors.
    """

    name: str
    pid: int
    samples: list[tuple[int, int, int]] = field(default_factory=list)

    def look(self, tiles: int) -> None:
        """Take a sample."""
        try:
            pages = int(Path(f"/proc/{self.pid}/statm").read_text().split()[1])
            self.samples.append((tiles, pages * os.sysconf("SC_PAGE_SIZE"), len(os.listdir(f"/proc/{self.pid}/fd"))))
        except OSError:
            return

    def growth(self) -> tuple[float, float]:
        """Return by how much bytes and descriptors grew since it was warm."""
        early = [sample for sample in self.samples if WARM <= sample[0] < WARM + WINDOW]
        late = [sample for sample in self.samples if sample[0] >= TILES - WINDOW]
        return _median(late, 1) - _median(early, 1), _median(late, 2) - _median(early, 2)


def _median(samples: Sequence[tuple[int, int, int]], column: int) -> float:
    return statistics.median(sample[column] for sample in samples)


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    for site in SITES:
        with arena.place() as place:
            victim = site.start(arena, SUBJECT, place)
            processes = _followed(site, victim)
            code = victim.wait()
            for process in processes:
                more, descriptors = process.growth()
                note = f"{process.name}: {more / 1e6:+.1f} MB, {descriptors:+g} descriptors"
                good = code == 0 and more < MOST and descriptors <= 0
                yield Case(good, f"{note}, ended with {code}", kinds=(note,))


def _followed(site: Site, victim: Victim) -> list[Process]:
    """Return the processes of a run, followed until all tiles are done."""
    processes = {victim.pid: Process(f"driver of {site.name}", victim.pid)}
    while victim.code is None and (tiles := _tiles(victim)) < TILES:
        for number, pid in enumerate(site.workers(victim)):
            processes.setdefault(pid, Process(f"worker {number + 1}", pid))
        for process in processes.values():
            process.look(tiles)
        time.sleep(0.05)
    return list(processes.values())


def _tiles(victim: Victim) -> int:
    """Return how many shards lie there."""
    folders = (victim.folder / "run").glob("shards/*/*/*")
    return sum(entry.name.startswith("tile-") for folder in folders for entry in os.scandir(folder))


FAULTS = (Fault("F36", "leaks over 10,000 tiles, per process", 0, 4, _attack),)
