"""The store: published whole or not at all, and no damaged byte is ever read as data."""

from __future__ import annotations

import errno
import io
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from quavsweep.config import Sweep
from quavsweep.errors import DamageError, DiskError, IdentityError, LockedError
from quavsweep.grid import Tile
from quavsweep.integrate import integrate_tile
from quavsweep.plan import make_plan
from quavsweep.provenance import Identity, identify
from quavsweep.store import RunFolder, ShardSet, read_result, write_shard
from quavsweep.store.evidence import read_shard
from quavsweep.store.publish import PatientFile, publish_hdf5
from quavsweep.store.shard import Shard, scan_shards, set_aside
from quavsweep.sweep import run_sweep
from quavsweep.whole import publish_bytes
from tests.conftest import YAW

TILE = Tile(1, 32, 45)
IDENTITY = Identity("evidence", "toolchain", "0-1", "rules", "subject")


@pytest.fixture
def sweep(make_sweep: Callable[..., Sweep]) -> Sweep:
    return make_sweep(YAW)


@pytest.fixture
def shard(sweep: Sweep, tmp_path: Path) -> Shard:
    tile = Tile(1, 32, 45)
    evidence = integrate_tile(make_plan(sweep, 16), tile, lambda: False)
    return write_shard(tmp_path / "shards" / "0-40000", tile, 32, sweep.measures.evidence, evidence, IDENTITY)


def _read(shard: Shard, sweep: Sweep, tile: Tile = TILE, identity: Identity = IDENTITY) -> dict[str, np.ndarray]:
    return read_shard(shard, tile, sweep.measures.evidence, sweep.extents, identity)


def test_a_shard_returns_what_was_written(shard: Shard, sweep: Sweep) -> None:
    evidence = integrate_tile(make_plan(sweep, 16), Tile(1, 32, 45), lambda: False)
    for name, values in _read(shard, sweep).items():
        np.testing.assert_array_equal(values, evidence[name])
    assert scan_shards(shard.path.parents[1]) == [shard]


def test_the_same_evidence_gives_the_same_bytes(shard: Shard, sweep: Sweep, tmp_path: Path) -> None:
    evidence = _read(shard, sweep)
    again = write_shard(tmp_path / "more" / "0-40000", Tile(1, 32, 45), 32, sweep.measures.evidence, evidence, IDENTITY)
    assert again.path.name == shard.path.name
    assert again.path.read_bytes() == shard.path.read_bytes()


def test_every_flipped_bit_is_seen(shard: Shard, sweep: Sweep) -> None:
    good = shard.path.read_bytes()
    for offset in np.random.default_rng(2).integers(0, len(good) * 8, 200):
        data = bytearray(good)
        data[offset // 8] ^= 1 << (offset % 8)
        shard.path.write_bytes(data)
        with pytest.raises(DamageError):
            _read(shard, sweep)


def test_truncated_and_foreign_shards_are_seen(shard: Shard, sweep: Sweep) -> None:
    with pytest.raises(DamageError, match="another tile"):
        _read(shard, sweep, identity=replace(IDENTITY, evidence="other"))
    with pytest.raises(IdentityError, match="another config"):
        _read(shard, sweep, identity=replace(IDENTITY, subject="other"))
    with pytest.raises(DamageError, match="another tile"):
        _read(shard, sweep, Tile(2, 64, 77))
    shard.path.write_bytes(shard.path.read_bytes()[:-1])
    assert scan_shards(shard.path.parents[1]) == []
    with pytest.raises(DamageError):
        _read(shard, sweep)


def test_what_is_set_aside_is_not_found(shard: Shard) -> None:
    set_aside(shard)
    assert scan_shards(shard.path.parents[1]) == []
    assert len(list(shard.path.parent.iterdir())) == 1


def test_a_folder_in_the_place_of_a_shard_is_no_shard(shard: Shard) -> None:
    shard.path.unlink()
    shard.path.mkdir()
    assert scan_shards(shard.path.parents[1]) == []


class _FullDisk(io.BytesIO):
    """A file that takes so many bytes and no more."""

    room = 3000

    def write(self, data: object) -> int:
        size = memoryview(data).nbytes  # type: ignore[arg-type]
        if self.tell() + size > self.room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return super().write(data)  # type: ignore[arg-type]


def test_hdf5_survives_a_disk_that_is_full() -> None:
    patient = PatientFile(_FullDisk())
    with h5py.File(patient, "w", libver=("v110", "v110")) as file:
        for i in range(20):
            file.create_dataset(f"x{i}", data=np.arange(1000.0), chunks=(100,), compression="gzip")
    assert patient.error is not None
    assert patient.error.errno == errno.ENOSPC


@pytest.mark.parametrize("in_memory", [True, False])
def test_a_failed_publication_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, in_memory: bool) -> None:
    def refuse(handle: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(DiskError, match="Input/output error"):
        publish_hdf5(lambda sha, size: tmp_path / "x.h5", lambda f: f.create_group("g"), in_memory=in_memory)
    assert list(tmp_path.iterdir()) == []


def test_publishing_under_a_file_is_a_disk_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(DiskError):
        publish_bytes(tmp_path / "file" / "x", b"1")


def test_two_runs_do_not_share_a_folder(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "run")
    with folder.lock(), pytest.raises(LockedError, match="process"), folder.lock():
        pass
    with folder.lock():
        pass


def test_a_lock_clears_what_a_killed_run_left_and_nothing_else(tmp_path: Path) -> None:
    litter = tmp_path / "shards" / "a" / "b" / "c" / ".quavsweep-x"
    litter.parent.mkdir(parents=True)
    litter.write_text("half")
    mine = tmp_path / "sub" / "draft.tmp"
    mine.parent.mkdir()
    mine.write_text("precious")
    with RunFolder(tmp_path).lock():
        assert not litter.exists()
    assert mine.read_text() == "precious"


def test_a_folder_in_the_place_of_a_file_is_moved_aside(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    publish_bytes(tmp_path / "x", b"1")
    assert (tmp_path / "x").read_bytes() == b"1"
    assert (tmp_path / "x.bad").is_dir()


def test_a_damaged_result_is_seen_and_rebuilt(sweep: Sweep, tmp_path: Path) -> None:
    path = run_sweep(sweep, tmp_path)
    good = path.read_bytes()
    for offset in np.random.default_rng(3).integers(0, len(good) * 8, 200):
        data = bytearray(good)
        data[offset // 8] ^= 1 << (offset % 8)
        path.write_bytes(data)
        with pytest.raises(DamageError):
            read_result(path)
    path.write_bytes(good[: len(good) // 2])
    with pytest.raises(DamageError):
        read_result(path)
    assert run_sweep(sweep, tmp_path).read_bytes() == good


def test_a_damaged_shard_is_done_again(sweep: Sweep, tmp_path: Path) -> None:
    path = run_sweep(sweep, tmp_path, tile_cells=32)
    good = path.read_bytes()
    identity = identify(sweep)
    shards = ShardSet.scan(RunFolder(tmp_path), sweep, identity, 1)
    assert shards.tile_cells == 32
    victim = shards.shards[0].path
    data = bytearray(victim.read_bytes())
    data[len(data) // 2] ^= 1
    victim.write_bytes(data)
    path.unlink()
    assert run_sweep(sweep, tmp_path).read_bytes() == good
    assert victim.with_suffix(".bad").exists()
    assert victim.exists()


INTERRUPTED = """
import os, signal, sys
from pathlib import Path
import numpy as np
from quavsweep.store.publish import give_way, publish_hdf5

signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background may ignore it

def write(file):
    os.kill(os.getpid(), signal.SIGINT)
    file.create_dataset("x", data=np.arange(100_000.0))  # calls functions of Python, where it would be raised
    try:
        give_way()
    except KeyboardInterrupt:
        print("between")
    os.kill(os.getpid(), signal.SIGINT)

try:
    publish_hdf5(lambda sha256, size: Path(sys.argv[1], "x.h5"), write, in_memory=False)
except KeyboardInterrupt:
    print("at the end", signal.getsignal(signal.SIGINT) is signal.default_int_handler)
"""


def test_ctrl_c_waits_while_hdf5_is_at_work(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", INTERRUPTED, tmp_path], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "between\nat the end True\n"), done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_system_that_refuses_says_nothing_about_a_shard(
    make_sweep: Callable[..., Sweep], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = make_sweep(YAW, ("num: 9", "num: 3"), ("num: 5", "num: 2"), ("200, duration: 600", "20, duration: 60"))
    path = run_sweep(sweep, tmp_path)
    shards = ShardSet.scan(RunFolder(tmp_path), sweep, identify(sweep))

    def refuse(*arguments: object) -> None:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(DiskError, match="Too many open files"):
        shards.discard_damaged()
    with pytest.raises(DiskError, match="Too many open files"):
        read_result(path)
    monkeypatch.undo()
    assert shards.damage() == {}
