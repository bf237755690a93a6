"""F17: workers of a cluster are killed again and again.

F18: all of them are, or the scheduler, or that is frozen. F19: a worker is frozen.
"""

from __future__ import annotations

import itertools
import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from quavsweep.executor import cluster, scheduler
from quavsweep.grid import Tile
from tests.batch_cluster import batch_cluster
from tests.faults.arena import HANG_SECONDS, Arena, sha256
from tests.faults.crew import (
    LARGE,
    SMALL,
    Site,
    has_kernel,
    have_children,
    local,
    scheduled,
    send,
    wait_for_shard,
    whole,
)
from tests.faults.fault import Case, Fault
from tests.faults.kill import litter
from tests.faults.subject import Subject

INTERVAL = 1.5, 3.5  # s between two kills
LIMIT = 600.0  # s, in which a run is done that is under attack
GONE_SECONDS = 60.0  # within which a run without a cluster has ended
SECONDS_PUSH = 6.0  # until it is seen that nobody answers, instead of 20 and 45
FROZEN_SECONDS = 60.0
FROZEN_SECONDS_PUSH = 4.0
SIDE_BY_SIDE = 3  # runs that mostly wait
MANY = 4  # cases: with more of them nothing is shortened


def _lost(arena: Arena, cases: int) -> Iterator[Case]:
    deaths = max(4, cases // 8)
    yield from _same_tile(arena, deaths)
    arena.undisturbed(whole(LARGE))
    left = cases - deaths
    with scheduled(arena.folder / "cluster") as site:
        for place in itertools.cycle((local(), site)):
            for case in _history(arena, place, min(left, max(3, cases // 8))):
                yield case
                left -= 1
            if left <= 0:
                return


def _history(arena: Arena, site: Site, most: int) -> Iterator[Case]:
    """Yield a case for each kill of a run, at most so many; the last of them tells how it ended."""
    with arena.place() as place:
        victim, kills, kinds = site.start(arena, LARGE, place), 0, tuple[str, ...]()
        deadline = time.monotonic() + LIMIT
        while kills < most and victim.code is None and time.monotonic() < deadline:
            victim.process.join(arena.rng.uniform(*INTERVAL))
            if victim.code is None and (pids := site.workers(victim)):
                if kills:
                    yield Case(True, kinds=kinds)
                pid, kills = arena.rng.choice([pid for pid in pids if has_kernel(pid)] or pids), kills + 1
                kinds = site.name, "doing tiles" if has_kernel(pid) else "starting"
                send(pid, signal.SIGKILL)
        code = victim.wait()
        note = f"ended with {code}: {victim.out[-300:]}" if code != 0 else _end(arena, LARGE, place)
        if kills or note:
            yield Case(not note, note, silent=note == "other bytes", kinds=kinds)


def _end(arena: Arena, subject: Subject, place: Path) -> str:
    """Return what is wrong with the result of a run that is done."""
    if sha256(place / "run" / "result.h5") != arena.undisturbed(whole(subject)).digest:
        return "other bytes"
    note = arena.finish(whole(subject), place)
    return note or (f"litter: {left}" if (left := litter(place / "run")) else "")


def _same_tile(arena: Arena, deaths: int) -> Iterator[Case]:
    """Yield a case for each death of a worker by one and the same tile, beside a tile that raises."""
    allowed = cluster.SETTINGS | {"distributed.scheduler.allowed-failures": min(10, deaths // 2 - 1)}
    before, cluster.SETTINGS = cluster.SETTINGS, allowed
    with arena.place() as place:
        tiles = [Tile(number, number, number + 1) for number in range(2)]
        with cluster.Cluster(processes=3) as crew:
            receipts = {}
            for receipt in crew.run(lambda tile: partial(_deadly, place, deaths, tile), tiles, threading.Event()):
                receipts[receipt.tile.index] = receipt
                (place / f"told-{receipt.tile.index}").touch()
        cluster.SETTINGS = before
        died, raised = (len(list(place.glob(f"{word}-*"))) for word in ("died", "raised"))
        outcome = receipts[1].outcome, str(receipts[0].error), died, raised
    good = outcome == ("done", "ArithmeticError: this tile raises", deaths, 1)
    for _ in range(deaths):
        yield Case(good, "" if good else f"{outcome}", kinds=("same tile",))


def _deadly(place: Path, deaths: int, tile: Tile, stopped: Callable[[], bool]) -> str:
    """Do a tile that raises, or one that, once the driver knows of that, kills the first so many workers that do it."""
    if tile.index == 0:
        (place / f"raised-{time.time_ns()}").touch()
        raise ArithmeticError("this tile raises")
    while not (place / "told-0").exists():
        time.sleep(0.05)
    time.sleep(0.3)  # in which the driver says that it wants the receipt no more
    if len(list(place.glob("died-*"))) < deaths:
        (place / f"died-{time.time_ns()}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def _side_by_side(attack: Callable[[str], Case], kinds: Iterable[str]) -> Iterator[Case]:
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        yield from pool.map(attack, kinds)


def _gone(arena: Arena, cases: int) -> Iterator[Case]:
    arena.undisturbed(whole(SMALL))
    kinds = itertools.islice(itertools.cycle(("workers", "scheduler", "all of it", "scheduler frozen")), cases)
    patience = (scheduler.CONNECT_SECONDS, cluster.SILENT_SECONDS) if cases > MANY else (SECONDS_PUSH, SECONDS_PUSH)
    return _side_by_side(partial(_without_cluster, arena, patience), kinds)


def _impatient(seconds: float, silent: float) -> None:
    """Let a client whose scheduler is gone, or says nothing, give up so soon; to be called in a victim."""
    have_children()
    scheduler.CONNECT_SECONDS = seconds
    cluster.SILENT_SECONDS = silent
    cluster.SETTINGS["distributed.comm.timeouts.connect"] = f"{seconds:g}s"


def _without_cluster(arena: Arena, patience: tuple[float, float], kind: str) -> Case:
    """Return what becomes of a run whose workers are killed, whose scheduler is, or all of them, or that is frozen."""
    with arena.place() as place, batch_cluster(place, {}, {}) as (file, running):
        arguments = ("--scheduler-file", str(file), "--worker-timeout", f"{patience[0]:g}s")
        victim = arena.start(SMALL, place, arguments, prepare=partial(_impatient, *patience))
        wait_for_shard(victim)
        victim.process.join(arena.rng.uniform(0.0, 2.0))
        if victim.code is not None:
            return Case(False, f"ended with {victim.code} before: {victim.out[-300:]}", kinds=(kind,))
        those = {"workers": running[1:], "scheduler": running[:1], "scheduler frozen": running[:1]}.get(kind, running)
        for process in those:
            process.send_signal(signal.SIGSTOP if "frozen" in kind else signal.SIGKILL)
        begin = time.monotonic()
        code = victim.wait()
        seconds = time.monotonic() - begin
        if code != 75 or seconds > GONE_SECONDS:
            note = f"{kind}: ended with {code} after {seconds:.1f} s: {victim.out[-300:]}"
        else:
            note = arena.finish(whole(SMALL), place)
        return Case(not note, note, silent=note == "other bytes", kinds=(kind,))


def _frozen(arena: Arena, cases: int) -> Iterator[Case]:
    arena.undisturbed(whole(SMALL))
    seconds = FROZEN_SECONDS if cases > MANY else FROZEN_SECONDS_PUSH
    return _side_by_side(partial(_with_frozen, arena, seconds), itertools.repeat("processes", cases))


def _with_frozen(arena: Arena, seconds: float, kind: str) -> Case:
    """Return what becomes of a run one of whose workers is frozen for a while."""
    with arena.place() as place:
        site = local(2)
        victim = site.start(arena, SMALL, place)
        wait_for_shard(victim)
        victim.process.join(arena.rng.uniform(0.0, 1.0))
        pids = [pid for pid in site.workers(victim) if has_kernel(pid)]
        if victim.code is not None or not pids:
            return Case(False, f"ended with {victim.code} before: {victim.out[-300:]}", kinds=(kind,))
        pid = arena.rng.choice(pids)
        send(pid, signal.SIGSTOP)
        victim.process.join(seconds)
        early = victim.code is not None
        send(pid, signal.SIGCONT)
        code = victim.wait(HANG_SECONDS)
        note = f"ended with {code}: {victim.out[-300:]}" if code != 0 else _end(arena, SMALL, place)
        return Case(not note, note, silent=note == "other bytes", kinds=("done without it" if early else "waited for",))


FAULTS = (
    Fault("F17", "one of three cluster workers killed, again and again", 10, 200, _lost),
    Fault("F18", "all workers of a cluster killed, its scheduler killed or frozen", 4, 20, _gone),
    Fault("F19", "a worker of a cluster frozen for a minute", 3, 20, _frozen),
)
