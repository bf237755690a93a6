"""Runs tiles on a cluster of dask.distributed: a sliding window of futures, and a watch over scheduler and workers.

Only receipts travel; workers publish their own shards on the file system that they share with the driver. A tile lost
with its worker is submitted again, as often as that happens; one that raised is not. Nothing is waited for without
end: a scheduler that does not answer and a cluster without workers end the run, which can be continued.
"""

from __future__ import annotations

import atexit
import collections
import contextlib
import logging
import math
import os
import queue
import signal
import threading
import time
import uuid
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import dask
import distributed
from distributed.deploy.spec import close_clusters

from quavsweep.errors import STOPPED, IdentityError, RefusedError, StoppedError
from quavsweep.executor import scheduler
from quavsweep.executor.receipt import Receipt, TaskOf
from quavsweep.executor.remote import abandon, do_remotely, greet
from quavsweep.executor.scheduler import check_address
from quavsweep.grid import Tile

SILENT_SECONDS = 45.0  # without an answer of the scheduler
WORKER_SECONDS = 600.0  # without any worker, where a batch system may start them
WORKER_SECONDS_LOCAL = 45.0
CLOSING_SECONDS = 1.0
HOPE_SECONDS = 5.0  # for another worker, when all that are there have been refused
GREETING_SECONDS = 20.0  # after which a worker that has not answered is greeted again
STARTS = 10  # of processes on this machine, until it is given up
AHEAD = 2  # tiles per thread that are submitted, so that none waits for the driver
SETTINGS = {
    "distributed.scheduler.allowed-failures": 10,
    "distributed.comm.timeouts.connect": f"{scheduler.CONNECT_SECONDS:g}s",
    "distributed.client.scheduler-info-interval": "1h",  # nobody reads it here, and it takes a connection of its own
    "distributed.admin.log-format": "%(message)s",
    "distributed.worker.profile.enabled": False,  # its samples fill 130 kB of a worker's memory per second
}


@dataclass
class Cluster:
    """A cluster of dask.distributed, joined or started when the first tiles are to be done; use it as a context.

    Parameters
    ----------
    address : str
        Of its scheduler, `tcp://...` or `tls://...`; certificates for TLS are those of dask's own config.
    scheduler_file : Path, optional
        The file in which its scheduler tells its address.
    processes : int
        Or else a cluster of so many processes on this machine, which listens on 127.0.0.1 alone.
    insecure : bool
        Whether a scheduler on another machine may be talked to without TLS.
    worker_timeout : float, optional
        For how long to wait for a worker [s]; default 600, of processes on this machine 45.

    Raises
    ------
    ConfigError
        If the address is none, or one of another machine without TLS, or there are no certificates for TLS.
    """

    address: str = ""
    scheduler_file: Path | None = None
    processes: int = 0
    insecure: bool = False
    worker_timeout: float | None = None
    _client: distributed.Client | None = field(default=None, init=False)
    _local: Any = field(default=None, init=False)

    def __enter__(self) -> Cluster:
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        logging.getLogger("tornado").setLevel(logging.CRITICAL)
        dask.config.set(SETTINGS)
        if not self.processes and self.scheduler_file is None:
            check_address(self.address, self.insecure)
        return self

    def _joined(self, stop: threading.Event) -> distributed.Client:
        """Return the client, of a cluster that is started, or joined, when it is first needed."""
        if self._client is None:
            if self.processes:
                self._local = self._started()
                self._client = distributed.Client(self._local, timeout=scheduler.CONNECT_SECONDS)
            else:
                self._client = scheduler.join(self.address, self.scheduler_file, self.insecure, stop)
        return self._client

    def _started(self) -> distributed.LocalCluster:
        """Return a cluster of this machine; a process that dies while it starts is no reason not to have one."""
        why: Exception | None = None
        for _ in range(STARTS):
            try:
                return distributed.LocalCluster(
                    n_workers=self.processes,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address="127.0.0.1:0",
                    scheduler_kwargs={"dashboard": False},  # or there is one where bokeh is installed
                    memory_limit=0,
                    silence_logs=logging.CRITICAL,
                )
            except (RuntimeError, OSError, TimeoutError) as error:
                why = error
        raise StoppedError(f"{self.processes} processes cannot be started ({why})", possible="run the same command")

    def __exit__(self, *exception: object) -> None:
        pids = [nanny.pid for nanny in self._local.workers.values()] if self._local is not None else []
        closing = threading.Thread(target=self._close, daemon=True)
        closing.start()
        closing.join(CLOSING_SECONDS)
        for pid in filter(None, pids):
            with contextlib.suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        atexit.unregister(close_clusters)  # it would wait for the killed ones for ten seconds more

    def _close(self) -> None:
        """Close what was opened, for as long as that takes."""
        with contextlib.suppress(Exception):
            if self._client is not None:
                self._client.close(timeout=CLOSING_SECONDS)
            if self._local is not None:
                self._local.close(timeout=CLOSING_SECONDS)

    def run(self, task_of: TaskOf, tiles: Sequence[Tile], stop: threading.Event) -> Iterator[Receipt]:
        """Yield a receipt for each tile, as they come; tiles are begun in their order.

        Raises
        ------
        ConfigError
            If what answers at the address is no scheduler.
        StoppedError
            If `stop` is set, no scheduler answers or it is gone, or no worker comes.
        IdentityError
            If all workers were refused because of their kernel or toolchain.
        """
        if not tiles:
            return
        client = self._joined(stop)
        waiting, running = collections.deque(tiles), dict[distributed.Future, _Sent]()
        ready: queue.Queue[distributed.Future] = queue.Queue()
        token, watch = uuid.uuid4().hex, _Watch(client, self._patience)
        try:
            while waiting or running:
                watch.check()
                if stop.is_set():
                    raise StoppedError(STOPPED)
                while waiting and len(running) < AHEAD * watch.threads:
                    tile, workers = waiting.popleft(), watch.allowed
                    future = client.submit(do_remotely, task_of(tile), tile, token, pure=False, workers=list(workers))
                    running[future] = _Sent(tile, frozenset(workers))
                    future.add_done_callback(ready.put)
                for future in [future for future, sent in running.items() if watch.lost(sent.workers)]:
                    waiting.appendleft(running.pop(future).tile)
                    future.release()
                try:
                    future = ready.get(timeout=0.1)
                except queue.Empty:
                    continue
                if future not in running:
                    continue
                sent = running.pop(future)
                receipt = watch.receipt(future, sent)
                future.release()  # or the scheduler has it done again when the worker dies that did it
                if receipt is None:
                    waiting.appendleft(sent.tile)
                else:
                    yield receipt
        finally:
            if running:
                _tell(client, abandon, token)
            watch.end()

    @property
    def _patience(self) -> float:
        """For how long to wait for a worker [s]."""
        if self.worker_timeout is not None:
            return self.worker_timeout
        return WORKER_SECONDS_LOCAL if self.processes else WORKER_SECONDS


def _tell(client: distributed.Client, function: Callable[..., None], *arguments: Any) -> None:
    """Call a function on each worker, and wait for none: some may be gone or frozen."""

    async def tell() -> None:
        with contextlib.suppress(Exception):
            await client.run(function, *arguments, on_error="ignore")

    client.loop.add_callback(tell)


@dataclass(frozen=True)
class _Sent:
    """A tile that was given to workers, any of which may do it."""

    tile: Tile
    workers: frozenset[str]


class _Watch:
    """Asks the scheduler each second which workers there are, greets new ones, and remembers which were refused.

    A worker without the same quavsweep would lose each tile that it is given without a word.
    """

    def __init__(self, client: distributed.Client, patience: float) -> None:
        self._client, self._patience = client, patience
        self._answered = self._staffed = self._hopeful = time.monotonic()
        self._workers: dict[str, int] = {}
        self._greeting = greet()
        self._asked: dict[str, float] = {}
        self._greeted: set[str] = set()
        self._refused: dict[str, IdentityError] = {}
        self._over = threading.Event()
        threading.Thread(target=self._ask, name="quavsweep-watch", daemon=True).start()

    def _ask(self) -> None:
        while not self._over.is_set():
            with contextlib.suppress(Exception):
                workers = dict(self._client.nthreads())
                self._answered = now = time.monotonic()
                self._forget(workers.keys())
                for address in workers.keys() - self._greeted - self._refused.keys():
                    if now - self._asked.get(address, -math.inf) > GREETING_SECONDS:
                        self._asked[address] = now
                        self._client.loop.add_callback(self._greet, address)
                self._workers = workers
            self._over.wait(0.5)

    def _forget(self, present: Set[str]) -> None:
        """Forget workers that are gone: another one may come at the same address, and a better one."""
        for address in {*self._asked, *self._greeted, *self._refused} - present:
            self._asked.pop(address, None)
            self._greeted.discard(address)
            self._refused.pop(address, None)

    async def _greet(self, address: str) -> None:
        """Find out whether a worker understands what it will be sent; one that is gone or frozen does not answer."""
        with contextlib.suppress(Exception):
            answer = (await self._client.run(greet, workers=[address], on_error="return"))[address]
            if answer == self._greeting:
                self._greeted.add(address)
            elif not isinstance(answer, OSError):  # which tells that it is gone
                why = f" ({type(answer).__name__}: {answer})" if isinstance(answer, Exception) else ""
                what = f"a worker has another quavsweep than this process, or none{why}"
                self._refused[address] = RefusedError(what, address, "install the same quavsweep there")

    def end(self) -> None:
        """Ask no more."""
        self._over.set()

    @property
    def allowed(self) -> dict[str, int]:
        """Threads of the workers that may be given tiles, by address."""
        workers = self._workers
        return {address: workers[address] for address in workers.keys() & self._greeted - self._refused.keys()}

    @property
    def threads(self) -> int:
        """How many tiles can be done at a time."""
        return sum(self.allowed.values())

    def lost(self, workers: frozenset[str]) -> bool:
        """Whether none of these workers is there any more: a tile that only they may do would wait for ever."""
        return not workers & self._workers.keys()

    def check(self) -> None:
        """Raise if there is nothing to wait for."""
        now = time.monotonic()
        if self._client.status in ("closed", "closing") or now - self._answered > SILENT_SECONDS:
            raise StoppedError("the scheduler is gone", possible="start it again and run the same command")
        if not self._workers or self._workers.keys() - self._refused.keys():
            self._hopeful = now
        elif now - self._hopeful > HOPE_SECONDS and (refused := [*self._refused.values()]):
            raise refused[0]
        if self.allowed:
            self._staffed = now
        elif now - self._staffed > self._patience:
            what = f"there was no worker for {self._patience:.0f} s"
            raise StoppedError(what, possible="start workers and run the same command")

    def receipt(self, future: distributed.Future, sent: _Sent) -> Receipt | None:
        """Return the receipt of a tile that is done; None if it was lost with its worker, or that was refused."""
        if future.status == "finished":
            receipt = self._fetched(future, sent)
            if receipt is not None and isinstance(receipt.error, RefusedError):
                self._refused[receipt.worker] = receipt.error
                return None
            return receipt
        if future.status == "error":
            error = future.exception(timeout=SILENT_SECONDS)
            if not isinstance(error, distributed.KilledWorker):
                raise IdentityError(
                    f"the cluster cannot do tiles ({type(error).__name__}: {error})",
                    possible="install the same quavsweep for its scheduler and its workers",
                ) from error
        return None

    def _fetched(self, future: distributed.Future, sent: _Sent) -> Receipt | None:
        """Return what lies with the worker that did a tile; with the worker it may go at any moment."""
        deadline = time.monotonic() + SILENT_SECONDS
        while time.monotonic() < deadline and future.status == "finished" and not self.lost(sent.workers):
            try:
                receipt: Receipt = future.result(timeout=1.0)
                return receipt
            except TimeoutError:
                continue
            except Exception:
                return None
        return None
