"""Sweeps: the bytes of a result depend on the config alone, and folders of other sweeps are refused."""

from __future__ import annotations

import hashlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import quavsweep.work
from quavsweep.codes import Region
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import DiskError, IdentityError, StoppedError
from quavsweep.executor import Threads
from quavsweep.grid import Tile
from quavsweep.plan import make_plan
from quavsweep.result import open_result
from quavsweep.store import RunFolder
from quavsweep.sweep import Progress, run_sweep
from quavsweep.tiling import choose_tile_cells
from tests.conftest import LORENZ, YAW

THUMBNAIL = (
    YAW.replace("num: 9", "num: 31").replace("num: 5", "num: 13").replace(": 200,", ": 1000,").replace("600", "3000")
)
SWEEPS = {"omega_c": THUMBNAIL, "lorenz": LORENZ.replace("num: 60", "num: 240")}


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the SHA-256 of the results of both sweeps, run plainly with one worker."""
    folder = tmp_path_factory.mktemp("undisturbed")
    digests = {name: _sha256(run_sweep(parse_sweep(t), folder / name, workers=1)) for name, t in SWEEPS.items()}
    regions = {name: set(open_result(folder / name)["region"].ravel()) for name in SWEEPS}
    assert {Region.SINK, Region.PERIODIC, Region.CHAOS} <= regions["omega_c"]
    assert {Region.SINK, Region.PERIODIC, Region.CHAOS, Region.UNBOUNDED} <= regions["lorenz"]
    return digests


@pytest.mark.parametrize("name", SWEEPS)
@pytest.mark.parametrize(
    "how",
    [
        {"workers": 2},
        {"workers": 3},
        {"tile_cells": 32},
        {"tile_cells": 50},
        {"tile_cells": 1000},
        {"lanes": 32},
        {"order_seed": 1, "tile_cells": 32},
        {"order_seed": 2, "tile_cells": 64, "workers": 3, "lanes": 32},
    ],
    ids=str,
)
def test_result_does_not_depend_on_workers_tiles_lanes_or_order(
    undisturbed: dict[str, str], tmp_path: Path, name: str, how: dict[str, int]
) -> None:
    assert _sha256(run_sweep(parse_sweep(SWEEPS[name]), tmp_path, **how)) == undisturbed[name]  # type: ignore[arg-type]


_CHILD = """
import sys, time
from pathlib import Path
import quavsweep.sweep as conductor
import quavsweep.work
from quavsweep.config import parse_sweep
plain = quavsweep.work.integrate_tile
def slow(*arguments):
    time.sleep(0.1)
    return plain(*arguments)
quavsweep.work.integrate_tile = slow
conductor.run_sweep(parse_sweep(Path(sys.argv[1]).read_text()), sys.argv[2], tile_cells=32)
"""


@pytest.mark.parametrize("name", SWEEPS)
@pytest.mark.parametrize("tiles", [1, 4])
def test_result_does_not_depend_on_a_kill(undisturbed: dict[str, str], tmp_path: Path, name: str, tiles: int) -> None:
    config, out = tmp_path / "config.yaml", tmp_path / "run"
    config.write_text(SWEEPS[name])
    with subprocess.Popen([sys.executable, "-c", _CHILD, str(config), str(out)]) as child:
        deadline = time.monotonic() + 60
        while len(list(out.rglob("tile-*.h5"))) < tiles and time.monotonic() < deadline:
            time.sleep(0.005)
        os.kill(child.pid, signal.SIGKILL)
    done = len(list(out.rglob("tile-*.h5")))
    assert tiles <= done < 8
    assert not (out / "result.h5").exists()
    assert _sha256(run_sweep(parse_sweep(SWEEPS[name]), out)) == undisturbed[name]


def test_a_finished_run_is_not_done_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = parse_sweep(YAW)
    path = run_sweep(sweep, tmp_path)
    before = path.stat().st_mtime_ns
    monkeypatch.setattr(quavsweep.work, "integrate_tile", None)
    assert run_sweep(sweep, tmp_path) == path
    assert path.stat().st_mtime_ns == before


def test_a_stopped_run_goes_on(undisturbed: dict[str, str], tmp_path: Path) -> None:
    sweep, stop = parse_sweep(THUMBNAIL), threading.Event()

    def observe(progress: Progress) -> None:
        if progress.tiles_done == 3:
            stop.set()

    with pytest.raises(StoppedError, match="of 13 tiles done; the same command continues it"):
        run_sweep(sweep, tmp_path, tile_cells=32, observe=observe, stop=stop)
    assert not (tmp_path / "result.h5").exists()
    unfinished = open_result(tmp_path)
    assert not unfinished.complete
    assert 0 < (unfinished["region"] != Region.NONE).sum() < sweep.grid.size
    assert _sha256(run_sweep(sweep, tmp_path)) == undisturbed["omega_c"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("dt: 0.02", "dt: 0.01"), "integrate.dt: 0.02 there, 0.01 here"),
        (("num: 9", "num: 10"), "axes.Omega1.num: 9 there, 10 here"),
        (("block: 25", "block: 10"), "measures.lyapunov.block: 25 there, 10 here"),
        (("initial:", "parameters: {Ix: 0.005}\ninitial:"), "parameters.Ix: 0.0049 there, 0.005 here"),
        (("duration: 600", "duration: 1200"), "integrate.duration: 600.0 there, 1200.0 here"),
    ],
)
def test_a_folder_of_another_sweep_is_refused(tmp_path: Path, change: tuple[str, str], says: str) -> None:
    run_sweep(parse_sweep(YAW), tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file() and path.name != "lock"}
    with pytest.raises(IdentityError, match=says):
        run_sweep(parse_sweep(YAW.replace(*change)), tmp_path)
    assert {path: path.read_bytes() for path in before} == before


def test_another_engine_or_toolchain_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = parse_sweep(YAW)
    run_sweep(sweep, tmp_path)
    monkeypatch.setattr("quavsweep.provenance.syntax_digest", lambda code: "edited")
    with pytest.raises(IdentityError, match=r"engine.quavsweep.analysis.certificate: \w+\.\.\. there, edited here"):
        run_sweep(sweep, tmp_path)


def test_thresholds_need_no_new_integration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = run_sweep(parse_sweep(YAW), tmp_path)
    before = _sha256(path)
    monkeypatch.setattr(quavsweep.work, "integrate_tile", None)
    run_sweep(parse_sweep(YAW + "classify: {neutral: 0.1}\n"), tmp_path)
    assert _sha256(path) != before
    run_sweep(parse_sweep(YAW), tmp_path)
    assert _sha256(path) == before


def test_the_name_and_the_order_of_keys_change_nothing(tmp_path: Path) -> None:
    first = run_sweep(parse_sweep(YAW), tmp_path / "a")
    swapped = YAW.replace("p: 0.001, q: 0.001, r: 0.001", "r: 0.001, q: 0.001, p: 0.001").replace("small", "other")
    assert _sha256(run_sweep(parse_sweep(swapped), tmp_path / "b")) == _sha256(first)


@pytest.mark.parametrize(
    "axes",
    [
        "{}",
        "{c: {values: [3, 5, 7]}}",
        "{Ix: {values: [0.004, 0.005]}, Omega1: {values: [100]}, c: {start: 3, stop: 7, num: 4}}",
    ],
)
def test_any_number_of_axes(tmp_path: Path, axes: str) -> None:
    head, tail = YAW.split("axes:")[0], YAW.split("num: 5}\n")[1]
    sweep = parse_sweep(f"{head}axes: {axes}\n{tail}")
    result = open_result(run_sweep(sweep, tmp_path))
    assert result["region"].shape == sweep.grid.shape
    assert result["lyapunov"].shape == (*sweep.grid.shape, 3)
    assert (result["region"] != Region.NONE).all()


def test_a_sweep_without_measures(tmp_path: Path, make_sweep: Callable[..., Sweep]) -> None:
    sweep = make_sweep(YAW, ("measures: {lyapunov: {exponents: 3, block: 25}}", ""))
    result = open_result(run_sweep(sweep, tmp_path))
    assert "lyapunov" not in result
    assert set(result["region"].ravel()) == {Region.SINK, Region.PERIODIC, Region.UNDECIDED}


@pytest.mark.parametrize("engine", ["h5netcdf", "netcdf4"])
def test_the_result_opens_in_xarray(tmp_path: Path, engine: str) -> None:
    xarray = pytest.importorskip("xarray")
    sweep = parse_sweep(YAW)
    path = run_sweep(sweep, tmp_path)
    with xarray.open_dataset(path, engine=engine) as data:
        assert data.region.dims == ("Omega1", "c")
        assert data.lyapunov.dims == ("Omega1", "c", "exponent")
        assert data.final_state.dims == ("Omega1", "c", "state")
        assert data.eigenvalue_re.dims == ("Omega1", "c", "eigenvalue")
        assert data.final_state.attrs["units"] == "rad s-1"
        assert data.region.dtype == data.status.dtype == data.was_chaotic.dtype == np.int8
        np.testing.assert_array_equal(data.Omega1, sweep.grid.axes[0].values)
        assert data.Omega1.attrs["units"] == "rad s-1"
        assert data.lyapunov.attrs["units"] == "s-1"
        assert list(data.state.values) == ["p", "q", "r"]
        assert data.region.attrs["flag_meanings"].split()[Region.CHAOS] == "chaos"
        assert data.region.attrs["flag_values"][Region.CHAOS] == Region.CHAOS
        assert data.time_used.dtype == np.float64
        result = open_result(path)
        for name in data.variables:
            if name != "state":
                np.testing.assert_array_equal(data[name].values, result[name])
    assert open_result(path).to_xarray().region.dims == ("Omega1", "c")


def test_an_axis_with_many_values_fits_into_the_result(tmp_path: Path) -> None:
    values = ", ".join(f"{50 + 0.01 * i:.2f}" for i in range(9000))
    text = YAW.replace("{start: 50, stop: 500, num: 9}", f"{{values: [{values}]}}").replace(
        "{start: 3, stop: 7, num: 5}", "{values: [5]}"
    )
    sweep = parse_sweep(text.replace("transient: 200, duration: 600", "transient: 0, duration: 2"))
    result = open_result(run_sweep(sweep, tmp_path))
    assert result["region"].shape == (9000, 1)


def test_shards_lie_under_both_identities(tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW), tmp_path)
    ((evidence, toolchain),) = RunFolder(tmp_path).identities()
    assert len(evidence) == len(toolchain) == 32
    assert [path.name for path in RunFolder(tmp_path).shards(evidence, toolchain).iterdir()] == ["0-40000"]


def test_a_run_that_cannot_fit_on_the_disk_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RunFolder, "free_bytes", 1000)
    with pytest.raises(DiskError, match=r"the shards need 7\.\d+e\+04 bytes, 1e\+03 are free"):
        run_sweep(parse_sweep(YAW), tmp_path)


def test_many_tiles_begin_at_once() -> None:
    begin, done = time.monotonic(), set()
    tiles = [Tile(i, i, i + 1) for i in range(20_000)]
    for receipt in Threads(2).run(lambda tile: lambda stopped: tile.index, tiles, threading.Event()):
        done.add(receipt.outcome)
    assert len(done) == 20_000
    assert time.monotonic() - begin < 10


@pytest.mark.parametrize(
    "change",
    [
        ("num: 5}", "num: 200000}"),
        ("transient: 200, duration: 600", "transient: 0.5, duration: 31.5"),
        ("block: 25}", "block: 25}, orbit: {every: 0.02}"),
    ],
    ids=["many cells", "short cells", "large cells"],
)
def test_the_evidence_of_a_tile_is_bounded(change: tuple[str, str]) -> None:
    sweep = parse_sweep(YAW.replace(*change))
    cells = choose_tile_cells(make_plan(sweep, 16))
    assert 1 <= cells <= 65536
    assert cells * sweep.cell_bytes <= 2**25
