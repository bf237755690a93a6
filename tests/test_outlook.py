"""What is told before, during and after a run: preview, progress, overview, summary, export, and new labels."""

from __future__ import annotations

import csv
import dataclasses
import importlib.util
import io
import json
import re
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from quavsweep.cli.describe import shares
from quavsweep.cli.text import seconds_of
from quavsweep.codes import Region
from quavsweep.config import Sweep, load_sweep, parse_sweep
from quavsweep.config.json_schema import json_schema
from quavsweep.config.template import make_template
from quavsweep.errors import ConfigError, IdentityError, StoppedError
from quavsweep.export import write_csv, write_netcdf
from quavsweep.grid import Tile
from quavsweep.models import NAMES, load_model
from quavsweep.overview import Lookout
from quavsweep.preview import preview_run
from quavsweep.progress import Progress
from quavsweep.provenance import DENSE_MODULES, HASHED_MODULES, identify, toolchain
from quavsweep.result import Result, open_result
from quavsweep.store import RunFolder
from quavsweep.summary import Check, summarise
from quavsweep.sweep import reclassify, run_sweep
from quavsweep.tiling import spread
from quavsweep.verify import verify_folder
from tests.conftest import LORENZ, YAW
from tests.test_ensemble import ENSEMBLE


def test_any_beginning_of_the_tiles_is_spread_over_all() -> None:
    tiles = [Tile(i, 10 * i, 10 * i + 10) for i in range(100)]
    order = [tile.index for tile in spread(tiles)]
    assert sorted(order) == list(range(100))
    for count in (5, 10, 30):
        gaps = np.diff(sorted([0, *order[:count], 99]))
        assert gaps.max() <= 3 * 100 / count


def test_time_left_comes_from_work_left() -> None:
    progress = Progress(tiles=4, cells=400, started=time.monotonic() - 10)
    assert progress.seconds_left is None
    progress.add(100, 100 * 50, np.zeros(8, dtype=int))
    progress.cells_done += 100  # of an earlier run
    assert progress.seconds_left == pytest.approx(20, rel=0.01)
    assert progress.speed == pytest.approx(10, rel=0.01)


def test_progress_tells_the_regions(tmp_path: Path) -> None:
    seen: list[tuple[int, int, str]] = []

    def observe(progress: Progress) -> None:
        seen.append((progress.cells_run, int(progress.regions.sum()), progress.stage))

    run_sweep(parse_sweep(YAW), tmp_path, observe=observe)
    assert all(cells == told for cells, told, _ in seen)
    assert seen[0][0] == 0
    assert seen[-1] == (45, 45, "writing the result")


def test_a_preview_counts_tiles_and_writes_nothing(tmp_path: Path) -> None:
    sweep = parse_sweep(YAW.replace("num: 9", "num: 31").replace("num: 5", "num: 13"))
    before = preview_run(sweep, tmp_path / "run")
    assert not (tmp_path / "run").exists()
    assert (before.valid, before.missing, before.bad) == (0, before.tiles, ())
    assert before.cells == 403
    assert 0 < before.seconds < 60
    assert 0 < before.steps_per_cell <= sweep.clock.steps
    assert before.free_bytes > before.shard_bytes > before.result_bytes > 0
    run_sweep(sweep, tmp_path / "run")
    shards = sorted((tmp_path / "run").rglob("tile-*.h5"))
    on_disk = sum(path.stat().st_size for path in shards)
    assert before.shard_bytes == pytest.approx(on_disk, rel=0.5)
    shards[0].write_bytes(shards[0].read_bytes()[:-1])
    data = bytearray(shards[1].read_bytes())
    data[len(data) // 2] ^= 1
    shards[1].write_bytes(data)
    shards[2].unlink()
    after = preview_run(sweep, tmp_path / "run")
    assert (after.valid, after.missing) == (after.tiles - 3, 3)
    assert [shards[0].name in after.bad[0], shards[1].name in after.bad[1]] == [True, True]
    assert "has not the size" in after.bad[0]
    assert "not those that were written" in after.bad[1]
    with pytest.raises(IdentityError, match=r"integrate.dt"):
        preview_run(parse_sweep(YAW.replace("0.02", "0.01")), tmp_path / "run")


@pytest.mark.parametrize("axes", ["{}", "{c: {values: [5]}}", "{c: {start: 3, stop: 7, num: 1000}}"])
def test_a_preview_of_any_grid(tmp_path: Path, axes: str) -> None:
    head, tail = YAW.split("axes:")[0], YAW.split("num: 5}\n")[1]
    preview = preview_run(parse_sweep(f"{head}axes: {axes}\n{tail}"), tmp_path)
    assert preview.missing == preview.tiles
    assert preview.seconds > 0


@pytest.mark.parametrize(
    "change", [("duration: 600", "duration: 1e10"), ("block: 25}", "block: 25}, orbit: {every: 1}")]
)
def test_a_preview_of_a_run_that_takes_years_takes_seconds(tmp_path: Path, change: tuple[str, str]) -> None:
    begin = time.monotonic()
    preview = preview_run(parse_sweep(YAW.replace(*change)), tmp_path)
    assert time.monotonic() - begin < 60
    assert preview.seconds > (1e4 if "1e10" in change[1] else 0)


def test_a_preview_can_be_stopped(tmp_path: Path) -> None:
    stop = threading.Event()
    stop.set()
    with pytest.raises(StoppedError):
        preview_run(parse_sweep(YAW), tmp_path, stop=stop)


def test_an_overview_of_an_unfinished_and_a_finished_run(tmp_path: Path) -> None:
    sweep = parse_sweep(YAW)
    stop = threading.Event()
    holders = []

    def observe(progress: Progress) -> None:
        holders.append(Lookout.of(tmp_path).folder.holder)
        if progress.tiles_done == 2:
            stop.set()

    with pytest.raises(StoppedError):
        run_sweep(sweep, tmp_path, tile_cells=5, workers=1, observe=observe, stop=stop)
    assert all("process" in holder for holder in holders)
    lookout = Lookout.of(tmp_path)
    part = lookout.look()
    assert part.holder == ""
    assert not part.complete
    assert part.tiles == 9
    assert part.looked_at == part.cells_done == 5 * part.tiles_done
    run_sweep(sweep, tmp_path)
    whole = lookout.look()
    assert whole.complete
    assert (whole.tiles_done, whole.cells_done, whole.looked_at) == (9, 45, 45)
    told = json.loads(json.dumps(whole.to_json()))
    region = open_result(tmp_path)["region"]
    assert told["regions"]["sink"] == (region == Region.SINK).sum()
    assert told["complete"] is True
    assert told["axes"] == {"Omega1": 9, "c": 5}
    assert told["running"] is None


def test_a_summary_counts_and_checks(tmp_path: Path) -> None:
    result = open_result(run_sweep(parse_sweep(YAW + "stop_early: false\n"), tmp_path))
    summary = summarise(result)
    assert sum(summary.regions.values()) == summary.cells == 45
    for name, check in (("sum_error", summary.sum_error), ("zero_error", summary.zero_error)):
        known = np.abs(result[name][np.isfinite(result[name])])
        assert check == (Check(known.max()) if known.size else Check(None, "no cell has it"))
    fewer = parse_sweep(YAW.replace("exponents: 3", "exponents: 2"))
    check = summarise(open_result(run_sweep(fewer, tmp_path / "fewer"))).sum_error
    assert check == Check(None, "2 of 3 exponents are measured")


def test_a_run_without_exponents_says_that_nothing_is_checked(tmp_path: Path) -> None:
    text = YAW.replace("{lyapunov: {exponents: 3, block: 25}}", "{}").replace("num: 9", "num: 2")
    rows = dict(shares(open_result(run_sweep(parse_sweep(text), tmp_path))))
    missing = "not available: no exponents are measured"
    assert (rows["sum check"], rows["zero check"]) == (missing, missing)


def test_labels_anew_from_stored_evidence(tmp_path: Path) -> None:
    path = run_sweep(parse_sweep(YAW), tmp_path)
    before = path.read_bytes()
    assert reclassify(tmp_path, ["classify.neutral=0.1"]) == path
    changed = open_result(path)
    assert changed.sweep.config.classify.neutral == 0.1
    assert load_sweep(tmp_path / "config.yaml").config.classify.neutral == 0.1
    assert path.read_bytes() != before
    reclassify(tmp_path, ["classify.neutral=2"])
    assert path.read_bytes() == before
    with pytest.raises(ConfigError, match="only thresholds can change"):
        reclassify(tmp_path, ["integrate.dt=0.01"])
    with pytest.raises(ConfigError, match="not the folder of a run"):
        reclassify(tmp_path / "none")
    next(tmp_path.rglob("tile-*.h5")).unlink()
    with pytest.raises(StoppedError, match="1 of 2 tiles are missing; nothing was changed"):
        reclassify(tmp_path, ["classify.neutral=0.1"])
    assert path.read_bytes() == before
    assert load_sweep(tmp_path / "config.yaml").config.classify.neutral == 2
    assert run_sweep(parse_sweep(YAW), tmp_path).read_bytes() == before


def test_another_toolchain_can_be_accepted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = parse_sweep(YAW)
    path = run_sweep(sweep, tmp_path)
    before = path.read_bytes()
    other = {**toolchain(), "numba": "0.1"}
    for module in ("provenance", "store.admission", "sweep"):
        monkeypatch.setattr(f"quavsweep.{module}.toolchain", lambda: other)
    with pytest.raises(IdentityError, match="or --accept-toolchain to start anew beside it"):
        run_sweep(sweep, tmp_path)
    run_sweep(sweep, tmp_path, accept_toolchain=True)
    assert path.read_bytes() != before
    np.testing.assert_array_equal(open_result(tmp_path)["region"].shape, (9, 5))
    monkeypatch.undo()
    assert run_sweep(sweep, tmp_path).read_bytes() == before


def test_a_table_of_text(tmp_path: Path) -> None:
    result = open_result(run_sweep(parse_sweep(LORENZ), tmp_path))
    stream = io.StringIO()
    write_csv(result, ["region", "lyapunov", "settle_time", "final_state"], stream)
    rows = list(csv.DictReader(io.StringIO(stream.getvalue())))
    assert list(rows[0]) == [
        *("rho", "region", "lyapunov_1", "lyapunov_2", "lyapunov_3", "settle_time"),
        *("final_state_x", "final_state_y", "final_state_z"),
    ]
    assert len(rows) == 60
    assert [float(row["rho"]) for row in rows] == result["rho"].tolist()
    assert [row["region"] for row in rows] == [Region(code).name.lower() for code in result["region"]]
    numbers = np.array([float(row["lyapunov_1"] or "nan") for row in rows])
    np.testing.assert_array_equal(numbers, result["lyapunov"][:, 0])
    with pytest.raises(ConfigError, match="there is no variable regoin, did you mean region"):
        write_csv(result, ["regoin"], stream)


def _table(result: Result, *names: str) -> list[dict[str, str]]:
    stream = io.StringIO()
    write_csv(result, names, stream)
    return list(csv.DictReader(io.StringIO(stream.getvalue())))


def test_tables_of_parameter_points_and_attractors(tmp_path: Path) -> None:
    result = open_result(run_sweep(parse_sweep(ENSEMBLE), tmp_path))
    rows = _table(result, "lifetime_after", "chaotic_share", "basin_share")
    assert [*rows[0]][:4] == ["Omega1", "lifetime_after", "chaotic_share", "basin_share_sink"]
    assert [float(row["Omega1"]) for row in rows] == [100, 196.4]
    np.testing.assert_array_equal([float(row["chaotic_share"]) for row in rows], result["chaotic_share"])
    rows = _table(result, "attractor_kind", "attractor_point", "attractor_share")
    numbers = result["attractor_number"].tolist()
    assert [*rows[0]][:4] == ["Omega1", "attractor_number", "attractor_kind", "attractor_point_p"]
    assert [int(row["attractor_number"]) for row in rows] == 2 * numbers
    assert [row["attractor_kind"] for row in rows[:3]] == ["sink", "sink", "none"]
    point = [float(row["attractor_point_r"] or "nan") for row in rows]
    np.testing.assert_array_equal(point, result["attractor_point"][..., 2].ravel())
    assert len(_table(result, "region", "attractor")) == 40
    with pytest.raises(
        ConfigError, match="lifetime does not fit into a table with a row for each cell; a table of its"
    ):
        _table(result, "region", "lifetime")
    with pytest.raises(ConfigError, match=r"lifetime does not fit .* each cell and attractor_number"):
        _table(result, "attractor_point", "lifetime")
    with pytest.raises(ConfigError, match="ensemble is no variable"):
        _table(result, "ensemble")


def test_a_table_of_orbits_has_a_row_for_each_time(tmp_path: Path) -> None:
    text = LORENZ.replace("num: 60", "num: 3").replace("block: 5}", "block: 5}, orbit: {every: 10}")
    result = open_result(run_sweep(parse_sweep(text), tmp_path))
    rows = _table(result, "orbit")
    assert [*rows[0]] == ["rho", "time", "orbit_x", "orbit_y", "orbit_z"]
    np.testing.assert_array_equal([float(row["orbit_y"] or "nan") for row in rows], result["orbit"][..., 1].ravel())


def test_a_netcdf_file_of_some_variables(tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    result = open_result(run_sweep(parse_sweep(YAW), tmp_path))
    write_netcdf(result, ["lyapunov", "region"], tmp_path / "part.nc")
    for engine in ("h5netcdf", "netcdf4"):
        with xarray.open_dataset(tmp_path / "part.nc", engine=engine) as data:
            assert set(data.data_vars) == {"lyapunov", "region"}
            assert data.lyapunov.dims == ("Omega1", "c", "exponent")
            np.testing.assert_array_equal(data.lyapunov, result["lyapunov"])
            assert data.lyapunov.attrs["units"] == "s-1"


@pytest.mark.parametrize("name", NAMES)
def test_a_template_is_a_config_that_runs(name: str) -> None:
    sweep = parse_sweep(make_template(load_model(name), "mine"))
    assert sweep.name == "mine"
    assert sweep.model.name == name
    assert not sweep.warnings or sweep.model.forcing_period  # whole periods are seldom round numbers
    text = make_template(load_model(name), "mine")
    for line in text.splitlines():  # what is commented out is right as well
        if line.strip().startswith(("# orbit:", "# samples:", "# peak:", "# first_time:", "# segment:")):
            parse_sweep(text.replace(line, line.replace("# ", "", 1)))


def test_the_schema_accepts_what_the_reader_accepts(make_sweep: Callable[..., Sweep]) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    check = jsonschema.Draft202012Validator(schema)
    canonical = make_sweep(YAW).canonical()
    assert not list(check.iter_errors(canonical))
    for broken in (
        {"axes": {"Omga1": {"values": [1]}}},
        {"parameters": {"Ix": -1}},
        {"initial": {"w": 0}},
        {"model": "no name"},
        {"integrate": {"dt": 0, "duration": 1}},
    ):
        assert list(check.iter_errors(canonical | broken)), broken
    assert "speed of the front and rear rotors [rad/s]" in json.dumps(schema)


def test_a_config_that_was_edited_labels_nothing(tmp_path: Path) -> None:
    path = run_sweep(parse_sweep(YAW), tmp_path)
    path.unlink()
    config = tmp_path / "config.yaml"
    config.write_text(config.read_text().replace("stop: 500", "stop: 600"))
    for read in (open_result, reclassify, verify_folder):
        with pytest.raises(IdentityError, match="made with another config than"):
            read(tmp_path)
    assert Lookout.of(tmp_path).look().looked_at == 0
    config.unlink()
    assert run_sweep(parse_sweep(YAW), tmp_path) == path


def test_a_result_is_not_lost_by_labels_anew(tmp_path: Path) -> None:
    path = run_sweep(parse_sweep(YAW), tmp_path)
    before = path.read_bytes()
    shard = next(tmp_path.rglob("tile-*.h5"))
    data = bytearray(shard.read_bytes())
    data[len(data) // 2] ^= 1
    shard.write_bytes(data)
    with pytest.raises(StoppedError, match="nothing was changed"):
        reclassify(tmp_path, ["classify.neutral=0.1"])
    assert path.read_bytes() == before


def test_whoever_looks_does_not_keep_a_run_out(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    with folder.lock():
        assert folder.holder
    stop = threading.Event()

    def look() -> None:
        while not stop.is_set():
            assert isinstance(folder.holder, str)

    looker = threading.Thread(target=look)
    looker.start()
    try:
        for _ in range(100):
            with folder.lock():
                pass
    finally:
        stop.set()
        looker.join()


def test_a_locked_start_leaves_files_that_are_being_written(tmp_path: Path) -> None:
    with subprocess.Popen(["sleep", "60"]) as other:
        living, dead = tmp_path / f".quavsweep-{other.pid}-a", tmp_path / ".quavsweep-4194999-b"
        living.touch()
        dead.touch()
        with RunFolder(tmp_path).lock():
            assert living.exists()
            assert not dead.exists()
        other.kill()


def test_evidence_is_that_of_every_module_that_makes_it() -> None:
    """What `integrate` imports decides its numbers; only what prints and compiles is seen in the kernel's text."""
    imported: set[str] = set()
    todo = ["quavsweep.integrate"]
    while todo:
        name = todo.pop()
        if name not in imported:
            imported.add(name)
            source = Path(importlib.util.find_spec(name).origin).read_text()  # type: ignore[union-attr, arg-type]
            todo += re.findall(r"^from (quavsweep\.[\w.]+) import", source, re.MULTILINE)
    elsewhere = {
        "quavsweep.errors",
        "quavsweep.nearest",
        "quavsweep.config",
        "quavsweep.models",
    }  # errors; in the values; in the program
    printed = {f"quavsweep.kernels.{name}" for name in ("compiler", "printer", "lower", "cache")}
    derived = {f"quavsweep.kernels.{name}" for name in ("lookup", "syntax", "described", "description", "installed")}
    hashed = {*HASHED_MODULES, *DENSE_MODULES}
    beside = {name for name in imported if name.startswith(tuple(elsewhere | printed | derived))}
    assert imported - beside == hashed


def test_what_is_said_of_quantities_is_part_of_a_result(monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = parse_sweep(YAW)
    other = dataclasses.replace(sweep, model=dataclasses.replace(sweep.model, source="elsewhere"))
    assert identify(other).evidence == identify(sweep).evidence
    assert identify(other).result != identify(sweep).result


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("3h50m", 13800), ("03:50:00", 13800), ("90s", 90), ("2d", 172800), ("45", 45), ("1.5 h", 5400), ("10min", 600)],
)
def test_times_as_people_write_them(text: str, seconds: float) -> None:
    assert seconds_of(text) == seconds


@pytest.mark.parametrize("text", ["", "soon", "3x", "-1", "0", "1e3", "3h soon", "1:2", "nan"])
def test_what_is_no_time(text: str) -> None:
    with pytest.raises(ConfigError):
        seconds_of(text)
