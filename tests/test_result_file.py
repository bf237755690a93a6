"""Result files: checked as a whole, read by variable, and made in bounded memory."""

from __future__ import annotations

import hashlib
import os
import pickle
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from quavsweep.codes import Status
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import DamageError
from quavsweep.plot import make_figure
from quavsweep.provenance import identify
from quavsweep.result import open_result
from quavsweep.store import Part, RunFolder, ShardSet, check_result, read_result
from quavsweep.store.outcome import write_outcome
from quavsweep.store.publish import _SEAL
from quavsweep.store.sealed_file import SealedFile
from quavsweep.summary import summarise
from quavsweep.sweep import run_sweep
from quavsweep.whole import publish_bytes
from tests.conftest import YAW


@pytest.fixture
def sweep(make_sweep: Callable[..., Sweep]) -> Sweep:
    return make_sweep(YAW)


def test_what_is_written_into_an_open_result_is_never_read(sweep: Sweep, tmp_path: Path) -> None:
    path = run_sweep(sweep, tmp_path)
    good = path.read_bytes()
    for offset in np.random.default_rng(4).integers(0, len(good), 20):
        path.write_bytes(good)
        os.utime(path, (0, 0))
        stored = read_result(path)
        assert (stored.data["region"] > 0).all()
        data = bytearray(good)
        data[offset] ^= 1
        path.write_bytes(data)
        with pytest.raises(DamageError):
            stored.data["lyapunov"]


def test_an_open_result_stays_what_it_was_when_another_takes_its_name(sweep: Sweep, tmp_path: Path) -> None:
    path = run_sweep(sweep, tmp_path)
    stored, same = read_result(path), read_result(path).data["lyapunov"]
    publish_bytes(path, b"another")
    np.testing.assert_array_equal(stored.data["lyapunov"], same)


def test_a_variable_is_read_when_it_is_asked_for(sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []
    plain = SealedFile.read

    def note(sealed: SealedFile, name: str, part: Part) -> np.ndarray:
        read.append(name)
        return plain(sealed, name, part)

    monkeypatch.setattr(SealedFile, "read", note)
    result = open_result(run_sweep(sweep, tmp_path).parent)
    read.clear()
    assert "lyapunov" in result
    assert "lyapunov" in result.variables
    assert read == []
    make_figure(result)
    assert set(read) == {"region", "lyapunov", "exponent"}
    whole = result["final_state"]
    assert result["final_state"] is whole
    assert read.count("final_state") == 1
    line = result.at(c=5.0)
    assert line.part("lyapunov_se", (slice(2, 4),)).shape == (2, 3)
    np.testing.assert_array_equal(line.part("lyapunov_se", (slice(2, 4),)), result["lyapunov_se"][2:4, 2])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(result.stored)).data["final_state"], whole)


def test_content_that_does_not_fit_its_digest_is_seen(sweep: Sweep, tmp_path: Path) -> None:
    path, other = run_sweep(sweep, tmp_path), tmp_path / "other.h5"
    assert check_result(path).file_attributes["result_id"] == identify(sweep).result
    other.write_bytes(path.read_bytes()[: -len(_SEAL % bytes(64))])
    with h5py.File(other, "r+") as file:
        file["lyapunov"][0, 0, 0] += 1e-12
    data = other.read_bytes()
    other.write_bytes(data + _SEAL % hashlib.sha256(data).hexdigest().encode())
    assert "lyapunov" in read_result(other).data  # its bytes are those that were written
    with pytest.raises(DamageError, match="its content is not"):
        check_result(other)


def test_a_part_that_is_not_there_is_no_damage(sweep: Sweep, tmp_path: Path) -> None:
    stored = read_result(run_sweep(sweep, tmp_path))
    with pytest.raises((ValueError, TypeError, IndexError)):
        stored.part("region", (slice(None),) * 5)
    assert (stored.data["region"] > 0).all()


def test_a_result_is_made_in_bounded_memory(tmp_path: Path) -> None:
    """Evidence of 60,000 cells, 81 MB, is made into a result that takes a fraction of that."""
    sweep = parse_sweep(
        YAW.replace("num: 9", "num: 300")
        .replace("num: 5}", "num: 200}")
        .replace("200, duration: 600", "8, duration: 24")
    )
    folder, identity = RunFolder(tmp_path), identify(sweep)
    shards = ShardSet.scan(folder, sweep, identity, 2_000)
    for tile in shards.missing():
        evidence = {v.name: v.empty(len(tile), sweep.extents) for v in sweep.measures.evidence}
        evidence["cell"][:] = np.arange(tile.start, tile.stop)
        evidence["status"][:] = Status.TIME_OVER
        evidence["steps"][:] = sweep.clock.steps
        for name in ("growth", "growth_total", "state"):
            evidence[name][:] = np.arange(tile.start, tile.stop).reshape(-1, *[1] * (evidence[name].ndim - 1))
        shards.add(shards.write(tile, evidence, 0, shards.end))
    tracemalloc.start()
    write_outcome(folder.result, shards, {}, lambda: False)
    result = open_result(folder.result)
    summary = summarise(result)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert summary.cells == 60_000
    assert peak < 50e6
    np.testing.assert_array_equal(result["final_state"][..., 0].ravel(), np.arange(60_000))
