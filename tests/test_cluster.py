"""A cluster of dask.distributed: the same bytes, whatever dies, and a word where there is nobody to talk to."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import dask
import pytest

from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import ConfigError, LockedError, RefusedError, StoppedError
from quavsweep.executor.cluster import Cluster
from quavsweep.grid import Tile
from quavsweep.plan import make_plan
from quavsweep.provenance import identify
from quavsweep.store import RunFolder, ShardSet
from quavsweep.sweep import run_sweep
from quavsweep.work import Errand, Order, _plan
from tests.batch_cluster import batch_cluster, start_worker
from tests.conftest import YAW
from tests.faults.crew import children


@pytest.fixture(scope="module")
def sweep() -> Sweep:
    return parse_sweep(YAW)


@pytest.fixture(scope="module")
def expected(sweep: Sweep, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return run_sweep(sweep, tmp_path_factory.mktemp("expected")).read_bytes()


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    with Cluster(processes=2) as opened:
        yield opened


def test_processes_give_the_bytes_of_threads(sweep: Sweep, expected: bytes, cluster: Cluster, tmp_path: Path) -> None:
    assert run_sweep(sweep, tmp_path, executor=cluster, tile_cells=7, order_seed=1).read_bytes() == expected


def test_workers_that_are_killed_lose_nothing(sweep: Sweep, expected: bytes, tmp_path: Path) -> None:
    with Cluster(processes=2) as cluster:

        def kill() -> None:
            while not over.wait(0.7):
                pids = [nanny.pid for nanny in cluster._local.workers.values() if nanny.pid]
                with contextlib.suppress(OSError, IndexError):
                    os.kill(pids[0], signal.SIGKILL)

        over = threading.Event()
        killer = threading.Timer(0.5, kill)
        killer.start()
        threading.Timer(6.0, over.set).start()
        result = run_sweep(sweep, tmp_path, executor=cluster, tile_cells=2)
        over.set()
        assert result.read_bytes() == expected


def test_a_tile_that_is_done_again_finds_its_shard(sweep: Sweep, tmp_path: Path) -> None:
    plan, identity = make_plan(sweep, 16), identify(sweep)
    folder = RunFolder(tmp_path)
    order = Order.of(plan, ShardSet.scan(folder, sweep, identity, 4), tmp_path)
    first, second = (Errand(order, Tile(3, 12, 16), check=False)(lambda: False) for _ in range(2))
    assert [shard.path for shard in second.shards] == [shard.path for shard in first.shards]
    assert second.steps == 0 < first.steps


def test_a_stop_is_quick_and_the_run_goes_on(sweep: Sweep, expected: bytes, cluster: Cluster, tmp_path: Path) -> None:
    stop = threading.Event()
    long = parse_sweep(YAW.replace("duration: 600", "duration: 400000") + "stop_early: false\n")
    threading.Timer(3.0, stop.set).start()
    begin = time.monotonic()
    with pytest.raises(StoppedError):
        run_sweep(long, tmp_path / "long", executor=cluster, stop=stop)
    assert time.monotonic() - begin < 6.0
    assert run_sweep(sweep, tmp_path / "short", executor=cluster).read_bytes() == expected


def test_a_worker_of_another_toolchain_is_refused(sweep: Sweep, expected: bytes, tmp_path: Path) -> None:
    other = {"NUMBA_OPT": "2"}
    one = batch_cluster(tmp_path, other)
    with one as (file, _), Cluster(scheduler_file=file) as cluster, pytest.raises(RefusedError, match="toolchain"):
        run_sweep(sweep, tmp_path / "run", executor=cluster)
    (tmp_path / "both").mkdir()
    with batch_cluster(tmp_path / "both", other, {}) as (file, _), Cluster(scheduler_file=file) as cluster:
        assert run_sweep(sweep, tmp_path / "run", executor=cluster).read_bytes() == expected


def test_a_scheduler_that_dies_ends_the_run(
    sweep: Sweep, expected: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("quavsweep.executor.scheduler.CONNECT_SECONDS", 5.0)
    with batch_cluster(tmp_path, {}) as (file, running), Cluster(scheduler_file=file) as cluster:
        threading.Timer(1.5, running[0].kill).start()
        begin = time.monotonic()
        with pytest.raises(StoppedError, match="scheduler"):
            run_sweep(sweep, tmp_path / "run", executor=cluster, tile_cells=1)
        assert time.monotonic() - begin < 60
    assert run_sweep(sweep, tmp_path / "run").read_bytes() == expected


def test_a_cluster_without_workers_is_not_waited_for(sweep: Sweep, tmp_path: Path) -> None:
    none, wanted = batch_cluster(tmp_path), pytest.raises(StoppedError, match="no worker for 1 s")
    with none as (file, _), Cluster(scheduler_file=file, worker_timeout=1.0) as cluster, wanted:
        run_sweep(sweep, tmp_path / "run", executor=cluster)


def test_a_worker_without_quavsweep_is_refused(
    sweep: Sweep, expected: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "broken" / "quavsweep").mkdir(parents=True)
    (tmp_path / "broken" / "quavsweep" / "__init__.py").write_text("raise ImportError('there is none')")
    monkeypatch.chdir(tmp_path)
    broken = {"PYTHONPATH": str(tmp_path / "broken")}
    one = batch_cluster(tmp_path, broken)
    with one as (file, _), Cluster(scheduler_file=file) as cluster, pytest.raises(RefusedError, match="there is none"):
        run_sweep(sweep, tmp_path / "run", executor=cluster)
    (tmp_path / "both").mkdir()
    with batch_cluster(tmp_path / "both", broken, {}) as (file, _), Cluster(scheduler_file=file) as cluster:
        assert run_sweep(sweep, tmp_path / "run", executor=cluster).read_bytes() == expected


def test_a_worker_that_takes_the_place_of_another_gets_its_tiles(sweep: Sweep, expected: bytes, tmp_path: Path) -> None:
    nannies = batch_cluster(tmp_path, {"NUMBA_OPT": "2"}, {}, words=())
    with nannies as (file, running), Cluster(scheduler_file=file) as cluster:
        folder = tmp_path / "run"

        def kill() -> None:
            while not any(folder.glob("shards/*/*/*/tile-*")):
                time.sleep(0.01)
            for pid in children(running[2].pid):
                os.kill(pid, signal.SIGKILL)

        threading.Thread(target=kill, daemon=True).start()
        assert run_sweep(sweep, folder, executor=cluster, tile_cells=1).read_bytes() == expected


def test_a_process_that_cannot_begin_is_refused_and_no_tile_fails(
    sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(sweep: Sweep) -> None:
        raise ModuleNotFoundError("no module")

    order = Order.of(make_plan(sweep, 16), ShardSet.scan(RunFolder(tmp_path), sweep, identify(sweep), 4), tmp_path)
    monkeypatch.setattr("quavsweep.work.identify", broken)
    monkeypatch.setattr("quavsweep.work._plan", _plan.__wrapped__)
    with pytest.raises(RefusedError, match="ModuleNotFoundError: no module"):
        Errand(order, Tile(0, 0, 4), check=False)(lambda: False)


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("tcp://10.1.2.3:8786", "encryption"),
        ("nowhere", "not the address"),
        ("http://localhost:1", "not the address"),
        ("tcp://localhost", "not the address"),
        ("tcp://localhost:99999", "not the address"),
        ("tcp://[::1:8786", "not the address"),
        ("tls://localhost:8786", "no certificates"),
    ],
)
def test_addresses_that_are_not_used(address: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says), Cluster(address):
        pass


def _join(address: str = "", file: Path | None = None) -> None:
    with Cluster(address, file) as cluster:
        list(cluster.run(lambda tile: partial(_odd, tile), [Tile(0, 0, 1)], threading.Event()))


def _server(greeting: bytes) -> socket.socket:
    """Return a server that says something to whoever comes, and then nothing."""
    server = socket.create_server(("127.0.0.1", 0))

    def greet() -> None:
        held = []
        with contextlib.suppress(OSError):
            while True:
                held.append(server.accept()[0])
                held[-1].sendall(greeting)

    threading.Thread(target=greet, daemon=True).start()
    return server


def test_nobody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quavsweep.executor.scheduler.CONNECT_SECONDS", 1.0)
    with pytest.raises(StoppedError, match=r"tcp://127\.0\.0\.1:9: no scheduler answers"):
        _join("tcp://127.0.0.1:9")


def test_one_that_takes_the_call_and_says_nothing_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quavsweep.executor.scheduler.CONNECT_SECONDS", 1.0)
    with _server(b"") as server, pytest.raises(StoppedError, match="no scheduler answers"):
        _join(f"tcp://127.0.0.1:{server.getsockname()[1]}")


def test_what_is_no_scheduler_is_a_mistake() -> None:
    junk = b"HTTP/1.1 400 Bad Request\r\n" + bytes(1000)
    with _server(junk) as server, pytest.raises(ConfigError, match="no scheduler of dask"):
        _join(f"tcp://127.0.0.1:{server.getsockname()[1]}")


def test_a_stop_is_heard_while_a_scheduler_is_waited_for(tmp_path: Path) -> None:
    stop = threading.Event()
    threading.Timer(0.3, stop.set).start()
    with Cluster(scheduler_file=tmp_path / "none") as cluster, pytest.raises(StoppedError, match="the run was stopped"):
        list(cluster.run(lambda tile: partial(_odd, tile), [Tile(0, 0, 1)], stop))


def test_nothing_is_joined_where_nothing_is_to_be_done(sweep: Sweep, expected: bytes, tmp_path: Path) -> None:
    run_sweep(sweep, tmp_path)
    with Cluster("tcp://127.0.0.1:9") as cluster:
        assert run_sweep(sweep, tmp_path, executor=cluster).read_bytes() == expected
        with RunFolder(tmp_path).lock(), pytest.raises(LockedError):
            run_sweep(sweep, tmp_path, executor=cluster)


def test_certificates_that_cannot_be_used_are_a_mistake(tmp_path: Path) -> None:
    (tmp_path / "ca.pem").write_text("no certificate")
    for file in (tmp_path / "none.pem", tmp_path / "ca.pem"):
        names = {f"distributed.comm.tls.{key}": str(file) for key in ("ca-file", "client.cert", "client.key")}
        with dask.config.set(names), pytest.raises(ConfigError, match=r"tls://127.*certificates cannot be used"):
            _join("tls://127.0.0.1:9")


@pytest.mark.skipif(shutil.which("openssl") is None, reason="needs openssl to make certificates")
def test_tls_with_its_certificates_and_with_others(
    sweep: Sweep, expected: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def settings(name: str) -> dict[str, str]:
        key, certificate = tmp_path / f"{name}.key", tmp_path / f"{name}.pem"
        words = f"openssl req -x509 -newkey rsa:2048 -nodes -keyout {key} -out {certificate} -days 2 -subj /CN={name}"
        subprocess.run(words.split(), check=True, capture_output=True)
        roles = {f"{role}.{kind}": file for role in ("scheduler", "worker", "client") for kind, file in
                 (("key", key), ("cert", certificate))}  # fmt: skip
        return {f"distributed.comm.tls.{name}": str(file) for name, file in {"ca-file": certificate, **roles}.items()}

    own, other = settings("own"), settings("other")
    for name, value in own.items():
        monkeypatch.setenv(f"DASK_{name.replace('.', '__').replace('-', '_').upper()}", value)
    with batch_cluster(tmp_path, {}, protocol="tls") as (file, _):
        with dask.config.set(other), pytest.raises(ConfigError, match="certificate does not match"):
            _join(file=file)
        with dask.config.set(own), Cluster(scheduler_file=file) as cluster:
            assert run_sweep(sweep, tmp_path / "run", executor=cluster).read_bytes() == expected


def test_a_worker_that_comes_in_the_place_of_a_refused_one_is_greeted(
    sweep: Sweep, expected: bytes, tmp_path: Path
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    words = ("--no-nanny", "--worker-port", str(port))
    with batch_cluster(tmp_path, {"NUMBA_OPT": "2"}, words=words) as (file, running):

        def mend() -> None:
            time.sleep(3.0)  # in which it is refused
            running[1].kill()
            running[1].wait()
            running.append(start_worker(file, {}, words))

        threading.Thread(target=mend, daemon=True).start()
        with Cluster(scheduler_file=file) as cluster:
            assert run_sweep(sweep, tmp_path / "run", executor=cluster).read_bytes() == expected


def test_the_file_of_a_scheduler_that_starts_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "scheduler.json"
    threading.Timer(0.3, file.write_text, ['{"address": "tcp://10.1.2.3:8786"}']).start()
    with pytest.raises(ConfigError, match=r"10\.1\.2\.3:8786: .*encryption"):
        _join(file=file)
    monkeypatch.setattr("quavsweep.executor.scheduler.CONNECT_SECONDS", 0.3)
    with pytest.raises(StoppedError, match="no scheduler has written"):
        _join(file=tmp_path / "no")
    file.write_text("[]")
    with pytest.raises(ConfigError, match="not the file of a scheduler"):
        _join(file=file)


def _odd(tile: Tile, stopped: Callable[[], bool]) -> int:
    if tile.index % 2:
        raise ArithmeticError(f"tile {tile.index} is odd")
    return tile.index


def test_a_tile_that_raises_does_not_stop_the_others(cluster: Cluster) -> None:
    tiles = [Tile(i, i, i + 1) for i in range(6)]
    receipts = sorted(
        cluster.run(lambda tile: partial(_odd, tile), tiles, threading.Event()), key=lambda r: r.tile.index
    )
    assert [receipt.outcome for receipt in receipts] == [0, None, 2, None, 4, None]
    assert "tile 5 is odd" in receipts[5].trace
    assert not any(receipt.fatal for receipt in receipts)
    assert all(receipt.worker.startswith("tcp://127.0.0.1") for receipt in receipts)
