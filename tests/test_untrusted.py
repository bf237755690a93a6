"""Files from elsewhere: nothing of them is run, no other file is read, and they cannot break or fill this process."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from quavsweep.cli.text import plain
from quavsweep.config import Sweep
from quavsweep.errors import ConfigError, DamageError
from quavsweep.overview import Lookout
from quavsweep.provenance import identify
from quavsweep.result import open_result
from quavsweep.store import RunFolder, ShardSet, check_result, evidence, foreign
from quavsweep.store.evidence import read_shard
from quavsweep.store.foreign import ForeignFile
from quavsweep.store.ledger import is_known, remember
from quavsweep.store.publish import seal_digest
from quavsweep.store.shard import Shard
from quavsweep.sweep import run_sweep
from quavsweep.verify import verify_folder
from tests.conftest import YAW
from tests.faults.hostile import CANARY, CORPUS, attack, attempt, hostile, look, make_canary
from tests.faults.mutant import SEAL, sealed, small_result


@pytest.fixture
def sweep(make_sweep: Callable[..., Sweep]) -> Sweep:
    return make_sweep(YAW, ("num: 9", "num: 3"), ("num: 5", "num: 2"), ("200, duration: 600", "20, duration: 60"))


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return small_result(tmp_path_factory.mktemp("run"))


def _elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Let this installation know nothing of what it has published."""
    monkeypatch.setattr("quavsweep.store.ledger.cache_folder", lambda: tmp_path / "no such folder")


def _shards(sweep: Sweep, folder: Path) -> ShardSet:
    run = RunFolder(folder)
    return ShardSet.scan(run, sweep, run.present_identity(identify(sweep)))


def test_what_was_published_here_is_read_here(sweep: Sweep, tmp_path: Path) -> None:
    path = run_sweep(sweep, tmp_path)
    with path.open("rb") as file:
        assert is_known(seal_digest(file))
    assert not open_result(path).stored.foreign
    assert RunFolder(tmp_path).is_own
    assert not is_known("")
    assert not is_known("0" * 64)
    remember("0" * 64)
    assert is_known("0" * 64)


def test_a_file_from_elsewhere_says_the_same(sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = run_sweep(sweep, tmp_path)
    own = open_result(path)
    numbers = {name: own[name] for name in own.stored.data}
    _elsewhere(monkeypatch, tmp_path)
    other = look(path, draw=True)
    assert other.stored.foreign
    assert list(other.stored.data) == list(numbers)
    for name, values in numbers.items():
        assert other[name].dtype == values.dtype
        np.testing.assert_array_equal(other[name], values)
        assert other.stored.dims[name] == own.stored.dims[name]
        assert repr(other.stored.attributes[name]) == repr(own.stored.attributes[name])
    np.testing.assert_array_equal(other.part("lyapunov", (1, slice(0, 1))), own.part("lyapunov", (1, slice(0, 1))))
    assert other.stored.file_attributes == own.stored.file_attributes
    assert check_result(path).file_attributes == own.stored.file_attributes
    with pytest.raises(IndexError):
        other.part("region", (slice(None),) * 5)
    assert verify_folder(tmp_path).damaged == ()
    assert Lookout.of(tmp_path).look().complete


@pytest.mark.parametrize("kind", ["starts", "curve", "records"])
def test_every_kind_of_result_can_come_from_elsewhere(
    kind: str, make_sweep: Callable[..., Sweep], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    axes = YAW[YAW.index("axes:") : YAW.index("integrate:")]
    changes = {
        "starts": ("axes:\n", "axes:\n  p: {start: -1, stop: 1, num: 3}\n"),
        "curve": (axes, "axes:\n  hover: {zip: {Omega1: [100, 200], c: [3, 4]}}\n"),
        "records": ("measures: {", "measures: {samples: {maxima: p, max: 5}, peak: {of: [p]}, "),
    }
    text = YAW.replace("{p: 0.001, ", "{") if kind == "starts" else YAW
    fewer = [] if kind == "curve" else [("num: 9", "num: 2"), ("num: 5}", "num: 2}")]
    path = run_sweep(make_sweep(text, *fewer, changes[kind], ("200, duration: 600", "20, duration: 60")), tmp_path)
    own = open_result(path)
    numbers = {name: own[name] for name in own.stored.data}
    _elsewhere(monkeypatch, tmp_path)
    other = open_result(path)
    assert other.stored.foreign
    assert other.points.stored.foreign
    assert other.stored.dims == own.stored.dims
    for name, values in numbers.items():
        np.testing.assert_array_equal(other[name], values)


def test_a_figure_that_cannot_be_drawn_is_damage(result: bytes, tmp_path: Path) -> None:
    raw, path = tmp_path / "raw", tmp_path / "evil.h5"
    raw.write_bytes(result[:-SEAL])
    with h5py.File(raw, "r+") as file:
        file["final_state"][...] = np.array([-1.7e308, 1.7e308, 0.0])
    path.write_bytes(sealed(raw.read_bytes()))
    done = subprocess.run(
        [sys.executable, "-m", "quavsweep", "plot", str(path), "--variable", "final_state.p"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode in (0, 2, 6), done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("name", CORPUS)
def test_hostile_files_are_refused_in_a_sentence(name: str, result: bytes, tmp_path: Path) -> None:
    make_canary(tmp_path)
    survived, silent, note = attempt(hostile(name, result, tmp_path))
    assert survived, note
    assert not silent
    assert note != "read"


def test_mutants_are_survived(tmp_path: Path) -> None:
    for survived, silent, kind, note in attack(40, np.random.default_rng(34), tmp_path):
        assert survived, (kind, note)
        assert not silent, (kind, note)


@pytest.mark.parametrize("name", ["external_storage", "external_link", "virtual", "foreign_filter", "hidden_bomb"])
def test_the_command_line_refuses_and_opens_nothing_else(name: str, result: bytes, tmp_path: Path) -> None:
    make_canary(tmp_path)
    path, trace = hostile(name, result, tmp_path), tmp_path / "trace"
    command = [sys.executable, "-m", "quavsweep", "plot", str(path)]
    if shutil.which("strace"):
        command = ["strace", "-f", "-o", str(trace), "-e", "trace=openat,open,execve", *command]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 6, done.stderr
    assert done.stderr.count("\n") == 1
    assert CANARY[6:].tobytes().decode() not in done.stdout + done.stderr
    if trace.exists():
        assert str(path) in trace.read_text()
        assert str(tmp_path / "canary") not in trace.read_text()


def test_a_reader_that_dies_is_damage_and_the_next_one_is_not(result: bytes, tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    path.write_bytes(result[:-SEAL])
    with path.open("rb") as raw:
        file = ForeignFile(raw, str(path))
        file._connection.shutdown(2)
        with pytest.raises(DamageError, match="its reader broke"):
            file.read("region")
        with pytest.raises(DamageError, match="its reader broke"):
            file.read("region")
        process = foreign._forks[0][1]
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        assert ForeignFile(raw, str(path)).read("region").shape == (3, 2)


def test_a_reader_that_never_answers_is_left(result: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(foreign, "SECONDS", 0.2)
    path = tmp_path / "result.h5"
    path.write_bytes(result)
    kept: list[int] = []  # descriptors that keep the other end open
    monkeypatch.setattr(foreign, "_hand_over", lambda handles: kept.extend(map(os.dup, handles)))
    with path.open("rb") as raw, pytest.raises(DamageError, match="took too long"):
        ForeignFile(raw, str(path))
    for handle in kept:
        os.close(handle)


def test_shards_are_read_without_hdf5(sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_sweep(sweep, tmp_path, tile_cells=4)
    shards = _shards(sweep, tmp_path)
    with h5py.File(shards.shards[0].path) as file:
        plainly = {name: file[name][()] for name in file}
    monkeypatch.setattr(evidence, "_read_elsewhere", lambda *_: pytest.fail("another process is asked"))
    for name, values in shards.read(0, {}).items():
        np.testing.assert_array_equal(values, plainly[name])
        assert values.dtype == plainly[name].dtype
        assert values.flags.aligned
        assert values.flags.writeable
    assert shards.damage() == {}


def _rewritten(shard: Shard, change: Callable[[h5py.File], None], **options: object) -> Shard:
    """Put a changed shard with a fitting name in the place of one, in another version of the format if wanted."""
    other = shard.path.with_name("other")
    with h5py.File(shard.path) as old, h5py.File(other, "w", **options) as file:
        for key, value in old.attrs.items():
            file.attrs[key] = value
        for name in old:
            old.copy(name, file)
        change(file)
    return _named(other, shard)


def _named(other: Path, shard: Shard) -> Shard:
    """Give a file the name that its content must have, in the place of a shard."""
    data = other.read_bytes()
    digest = hashlib.sha256(data).hexdigest()
    path = shard.path.with_name(
        shard.path.name.replace(shard.sha256, digest).replace(f".{shard.size}.", f".{len(data)}.")
    )
    shard.path.unlink()
    other.rename(path)
    return Shard(path, shard.tile, shard.tile_cells, len(data), digest, shard.listed)


def test_shards_of_another_hdf5_are_read_elsewhere(sweep: Sweep, tmp_path: Path) -> None:
    run_sweep(sweep, tmp_path, tile_cells=4)
    shards = _shards(sweep, tmp_path)
    good = shards.read(0, {})
    _rewritten(shards.shards[0], lambda file: None, libver="earliest")
    again = _shards(sweep, tmp_path)
    assert again.shards[0].sha256 != shards.shards[0].sha256
    for name, values in again.read(0, {}).items():
        np.testing.assert_array_equal(values, good[name])
    assert verify_folder(tmp_path).damaged == ()


def _external(file: h5py.File) -> None:
    shape = file["status"].shape
    del file["status"]
    file.create_dataset("status", shape, np.int8, external=[("canary", 0, 64)])


def _linked(file: h5py.File) -> None:
    del file["status"]
    file["status"] = h5py.ExternalLink("canary.h5", "/region")


def _coded(file: h5py.File) -> None:
    file["status"][0] = 99


def _shortened(file: h5py.File) -> None:
    del file["status"]
    file["status"] = np.zeros(1, np.int8)


@pytest.mark.parametrize("change", [_external, _linked, _coded, _shortened])
def test_hostile_shards_are_damage(change: Callable[[h5py.File], None], sweep: Sweep, tmp_path: Path) -> None:
    path = run_sweep(sweep, tmp_path, tile_cells=4)
    good = path.read_bytes()
    shards = _shards(sweep, tmp_path)
    bad = _rewritten(shards.shards[0], change)
    with pytest.raises(DamageError):
        read_shard(bad, shards.tile(0), sweep.measures.evidence, sweep.extents, shards.identity)
    path.unlink()
    with pytest.raises(DamageError):
        open_result(tmp_path)
    assert len(verify_folder(tmp_path).damaged) == 1
    assert run_sweep(sweep, tmp_path, tile_cells=4).read_bytes() == good


def test_a_shard_of_a_name_for_all_memory_is_passed_over(sweep: Sweep, tmp_path: Path) -> None:
    path = run_sweep(sweep, tmp_path, tile_cells=4)
    shard = _shards(sweep, tmp_path).shards[0]
    shard.path.with_name(shard.path.name.replace(".4.", f".{10**15}.", 1)).write_bytes(shard.path.read_bytes())
    path.unlink()
    assert open_result(tmp_path).complete


def test_a_run_from_elsewhere_is_bounded(sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_sweep(sweep, tmp_path, tile_cells=4).unlink()
    _elsewhere(monkeypatch, tmp_path)
    assert open_result(tmp_path).complete
    config = tmp_path / "config.yaml"
    text = config.read_text()
    config.write_text(text.replace("num: 3", "num: 1000000").replace("num: 2", "num: 1000000"))
    with pytest.raises(ConfigError, match="too many"):
        open_result(tmp_path)


def test_a_large_description_is_not_read(sweep: Sweep, tmp_path: Path) -> None:
    run_sweep(sweep, tmp_path)
    with (tmp_path / "model.json").open("wb") as file:
        file.truncate(2**36)
    with pytest.raises(DamageError, match="not the description"):
        verify_folder(tmp_path)


def test_a_record_that_is_none_is_passed_over(tmp_path: Path) -> None:
    for text in ("[" * 100_000, "9" * 10_000, "\ufffd", json.dumps([1])):
        (tmp_path / "run.json").write_text(text)
        assert RunFolder(tmp_path).read_starts() == []


@pytest.mark.parametrize("name", ["lock", "result.h5", "config.yaml", "run.json", "log.jsonl"])
def test_no_pipe_is_waited_for(name: str, sweep: Sweep, tmp_path: Path) -> None:
    run_sweep(sweep, tmp_path / "run")
    (tmp_path / "run" / name).unlink()
    os.mkfifo(tmp_path / "run" / name)
    words = {"status": (), "verify": (), "plot": ("--out", "map.png"), "diff": ("run",)}
    for verb, more in words.items():
        done = subprocess.run(
            [sys.executable, "-m", "quavsweep", verb, "run", *more],
            cwd=tmp_path, timeout=60, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode in (0, 2, 6), done.stderr


def test_nothing_that_is_printed_moves_the_cursor() -> None:
    assert plain("a\x1b[2Jb\x9bc\rd\n\te") == "a\ufffd[2Jb\ufffdc\ufffdd\n\te"


def test_a_result_too_large_for_one_from_elsewhere_is_made_again_by_its_own_run(
    sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = run_sweep(sweep, tmp_path / "run").read_bytes()
    _elsewhere(monkeypatch, tmp_path)
    monkeypatch.setattr("quavsweep.store.fit.MOST_CELLS", 4)
    with pytest.raises(ConfigError, match="too many"):
        open_result(tmp_path / "run")
    assert run_sweep(sweep, tmp_path / "run").read_bytes() == before
