"""Two results beside each other: changes against naive twins, common cells, identity, and the verb."""

from __future__ import annotations

import io
import json
import os
import pty
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import quavsweep
from quavsweep.codes import REGION, Region
from quavsweep.config import parse_sweep
from quavsweep.difference import Difference, common, compare, compare_results, find_common, told_of_files
from quavsweep.difference.move import Mover, Sizes
from quavsweep.errors import ConfigError
from quavsweep.export import write_changes
from quavsweep.grid import Axis
from quavsweep.result import Result, open_result
from quavsweep.store.netcdf import DIGEST
from quavsweep.sweep import run_sweep
from tests.conftest import YAW
from tests.test_cli import COMMAND, _run
from tests.test_ensemble import ENSEMBLE

# The same parameters at a coarser grid, its axes the other way round, and with another step and other thresholds.
TURNED = (
    YAW.replace("  Omega1: {start: 50, stop: 500, num: 9}\n  c: {start: 3, stop: 7, num: 5}\n", "  c: C\n  Omega1: O\n")
    .replace("O\n", "{values: [500, 162.5, 51, 218.75]}\n")
    .replace("c: C", "c: {start: 3, stop: 7, num: 3}")
    .replace("dt: 0.02", "dt: 0.025")
    + "\nclassify: {errors: 400}\n"
)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the folders of a run, one of the same at another grid and step, and of starts."""
    folder = tmp_path_factory.mktemp("runs")
    texts = {"yaw": YAW, "turned": TURNED, "starts": ENSEMBLE}
    for name, text in texts.items():
        run_sweep(parse_sweep(text), folder / name)
    return {name: folder / name for name in texts}


def _common_values(a: Result, b: Result, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a variable at the common cells of yaw and turned, picked by hand."""
    omega, c = list(a["Omega1"]), list(a["c"])
    rows = [(omega.index(o), c.index(v)) for o in (162.5, 218.75, 500.0) for v in (3.0, 5.0, 7.0)]
    others = [(list(b["c"]).index(c[j]), list(b["Omega1"]).index(omega[i])) for i, j in rows]
    return np.stack([a[name][i] for i in rows]), np.stack([b[name][i] for i in others])


def test_changes_are_those_of_a_naive_twin(runs: dict[str, Path]) -> None:
    a, b = open_result(runs["yaw"]), open_result(runs["turned"])
    found = compare_results(runs["yaw"], runs["turned"])
    before, after = _common_values(a, b, "region")
    same = before == after
    assert (found.cells, found.common, found.compared) == ((45, 12), 9, 9)
    assert found.same == same.sum()
    assert 0 < found.changed < 9
    pairs = {(REGION[i].name, REGION[j].name) for i, j in zip(before, after, strict=True) if i != j}
    assert {(change.before, change.after) for change in found.changes} == pairs
    assert sum(change.cells for change in found.changes) == found.changed
    (x, y), (sx, sy) = (_common_values(a, b, name) for name in ("lyapunov", "lyapunov_se"))
    for k, move in enumerate(found.moves):
        size, error = np.abs(y - x)[same, k], np.hypot(sx, sy)[same, k]
        measured = (error > 0) & np.isfinite(error)
        assert (move.exponent, move.cells, move.missing) == (k + 1, size.size, 0)
        assert move.largest == size.max()
        np.testing.assert_allclose(move.median, np.sort(size)[(size.size - 1) // 2], rtol=2e-3)
        assert move.with_error == measured.sum()
        assert move.exact == (error == 0).sum()
        assert move.largest_exact == size[error == 0].max()
        if measured.any():
            assert move.largest_in_errors == (size[measured] / error[measured]).max()
    sizes = np.sort(np.abs(y - x)[same].max(axis=1))[::-1]
    assert [abs(moved.change) for moved in found.farthest] == list(sizes[:5])
    first = found.farthest[0]
    i, j = list(a["Omega1"]).index(first.values["Omega1"]), list(a["c"]).index(first.values["c"])
    assert REGION[a["region"][i, j]].name == first.region
    assert found.config["classify.errors"] == (3.0, 400.0)
    assert found.config["integrate.dt"] == (0.02, 0.025)
    assert found.variables["final_state"] == 9
    assert not found.evidence
    assert found.toolchain
    assert sum(n for n, _ in found.status.values()) == sum(n for _, n in found.status.values()) == 9


def test_the_other_way_round_changes_are_the_other_way(runs: dict[str, Path]) -> None:
    there, back = (compare_results(*(runs[name] for name in names)) for names in (("yaw", "turned"), ("turned", "yaw")))
    assert {(c.before, c.after, c.cells) for c in there.changes} == {(c.after, c.before, c.cells) for c in back.changes}
    assert there.moves == back.moves
    assert {m.change for m in there.farthest} == {-m.change for m in back.farthest}


@pytest.mark.parametrize("pair", [("yaw", "turned"), ("yaw", "yaw"), ("starts", "starts")])
def test_boxes_change_nothing(runs: dict[str, Path], pair: tuple[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    whole = compare_results(*(runs[name] for name in pair))
    texts = []
    for room in (1, 20_000, 10**9):
        monkeypatch.setattr(common, "BOX_BYTES", room)
        assert compare_results(*(runs[name] for name in pair)).to_json() == whole.to_json()
        stream = io.StringIO()
        write_changes(find_common(*(open_result(runs[name]) for name in pair)), stream)
        texts.append(stream.getvalue())
    assert len(set(texts)) == 1
    assert len(texts[0].splitlines()) == 1 + whole.changed


def test_boxes_are_small_in_both(runs: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    pair = [open_result(runs[name]) for name in ("yaw", "turned")]
    found = find_common(*pair)
    monkeypatch.setattr(common, "BOX_BYTES", 6 * pair[0].sweep.cell_bytes)
    boxes = list(found.boxes())
    assert len(boxes) > 1
    assert np.concatenate([found.cells(box) for box in boxes]).tolist() == list(range(9))
    for box in boxes:
        for side, result in enumerate(pair):
            spans = [np.ptp(found.indices[name][side][part]) + 1 for name, part in box.items()]
            assert np.prod(spans) <= 6
            assert result.sweep.grid.size > 6


def test_how_much_is_identical(runs: dict[str, Path], tmp_path: Path) -> None:
    assert compare_results(runs["yaw"], runs["yaw"] / "result.h5").identical == "bytes"
    yaw = open_result(runs["yaw"])
    assert compare_results(yaw, yaw).identical == "data"
    shutil.copytree(runs["yaw"], tmp_path / "open")
    (tmp_path / "open" / "result.h5").unlink()
    unfinished = compare_results(runs["yaw"], tmp_path / "open")
    assert unfinished.identical == "content"
    assert unfinished.changed == 0
    run_sweep(parse_sweep(YAW + "\nevidence: summary\n"), tmp_path / "summary")
    summary = compare_results(runs["yaw"], tmp_path / "summary")
    assert summary.identical == "data"
    assert summary.config == {"evidence": ("full", "summary")}
    assert summary.variables == {}
    assert compare_results(runs["yaw"], runs["turned"]).identical == ""


def test_what_a_file_from_elsewhere_says_of_itself_is_no_proof(runs: dict[str, Path]) -> None:
    yaw, turned = open_result(runs["yaw"]), open_result(runs["turned"])
    told = {**turned.stored.file_attributes, DIGEST: yaw.stored.file_attributes[DIGEST]}
    liar = replace(turned, stored=replace(turned.stored, file_attributes=told, foreign=True))
    found = told_of_files(compare_results(yaw, liar), (yaw, liar), (runs["yaw"], runs["turned"]))
    assert found.identical == ""


def test_what_is_not_computed_did_not_change(runs: dict[str, Path], tmp_path: Path) -> None:
    run_sweep(parse_sweep(YAW), tmp_path, tile_cells=16).unlink()
    next(tmp_path.glob("shards/*/*/*/tile-0000001*")).unlink()
    found = compare_results(runs["yaw"], tmp_path)
    assert (found.common, found.compared, found.same, found.changes) == (45, 29, 29, ())
    assert found.status["not_computed"] == (0, 16)
    assert all(move.largest == 0 for move in found.moves)
    assert found.identical == ""


def test_starts_and_points_are_compared(runs: dict[str, Path], tmp_path: Path) -> None:
    fewer = ENSEMBLE.replace("num: 20", "num: 12").replace("[100, 196.4]", "[196.4, 120]")
    found = compare_results(runs["starts"], run_sweep(parse_sweep(fewer), tmp_path))
    assert found.common == found.same == 12
    assert found.moves == ()
    assert found.variables["starts"] == 1
    assert "final_state" not in found.variables
    assert found.config["axes.ensemble.num"] == (20, 12)


def test_curves_are_matched_by_all_their_quantities(runs: dict[str, Path]) -> None:
    a = Axis("curve", (0, 1, 2, 3), (("x", (1.0, 1.0, 2.0, 3.0)), ("y", (0.1 + 0.2, 5.0, 6.0, 7.0))))
    b = Axis("curve", (0, 1, 2), (("x", (3.0, 1.0, 1.0)), ("y", (8.0, 5.0, 0.3))))
    one, other = common._matching(a, b)
    assert (one.tolist(), other.tolist()) == ([0, 1], [2, 1])
    for values in (np.linspace(-1, 1, 2001), np.geomspace(1e-12, 1, 400)):
        one, other = common._matching(Axis("x", tuple(values)), Axis("x", tuple(values[::-2] * (1 + 3e-16))))
        np.testing.assert_array_equal(one, np.arange(len(values))[::-2][::-1])
        np.testing.assert_array_equal(values[::-2][other], values[one])


def test_a_single_cell_is_compared(tmp_path: Path) -> None:
    text = YAW.partition("axes:")[0] + "parameters: {Omega1: 250, c: 5}\nintegrate:" + YAW.partition("integrate:")[2]
    run_sweep(parse_sweep(text), tmp_path / "a")
    run_sweep(parse_sweep(text.replace("duration: 600", "duration: 800")), tmp_path / "b")
    found = compare_results(tmp_path / "a", tmp_path / "b")
    assert found.common == found.compared == 1
    assert found.config["integrate.duration"] == (600.0, 800.0)


def test_the_median_needs_no_memory_and_is_near() -> None:
    sizes = Sizes()
    assert np.isnan(sizes.median)
    values = np.abs(np.random.default_rng(1).lognormal(-8, 5, 100_001))
    for part in np.array_split(values, 17):
        sizes.add(part)
    np.testing.assert_allclose(sizes.median, np.median(values), rtol=2e-3)
    assert sizes.largest == values.max()
    zeros = Sizes()
    zeros.add(np.array([0.0, 0.0, np.inf]))
    assert zeros.median == 0.0


def test_exact_exponents_have_no_standard_error() -> None:
    mover = Mover()
    change, error = np.array([1e-12, 3.0, 2.0, np.nan]), np.array([0.0, 2.0, np.inf, np.nan])
    mover.add(change, error, np.array([False, False, False, True]))
    move = mover.told(1)
    assert (move.cells, move.missing, move.with_error, move.exact) == (3, 1, 1, 1)
    assert (move.largest, move.largest_in_errors, move.largest_exact) == (3.0, 1.5, 1e-12)


def test_the_order_of_axes_is_told(tmp_path: Path) -> None:
    small = YAW.replace("num: 9", "num: 2").replace("num: 5", "num: 2")
    omega, c = (
        f"  {name}: {{start: {low}, stop: {high}, num: 2}}\n" for name, low, high in (("Omega1", 50, 500), ("c", 3, 7))
    )
    assert omega + c in small
    for name, text in (("a", small), ("b", small.replace(omega + c, c + omega))):
        run_sweep(parse_sweep(text), tmp_path / name)
    found = compare_results(tmp_path / "a", tmp_path / "b")
    assert found.config == {"axes.order": ("Omega1, c", "c, Omega1")}
    assert found.engine


def test_another_engine_is_told_beside_other_thresholds(
    runs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("quavsweep.provenance.HASHED_MODULES", ())
    run_sweep(parse_sweep(YAW + "classify: {errors: 9}\n"), tmp_path / "b")
    found = compare_results(runs["yaw"], tmp_path / "b")
    assert list(found.config) == ["classify.errors"]
    assert not found.engine
    assert "another engine or model" in _run("diff", runs["yaw"], tmp_path / "b", cwd=tmp_path).stdout
    assert compare_results(runs["yaw"], runs["turned"]).engine  # as far as can be told


def test_what_cannot_be_compared_is_told(runs: dict[str, Path], tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="axes of the first are Omega1, c, those of the second Omega1, ensemble"):
        compare_results(runs["yaw"], runs["starts"])
    run_sweep(
        parse_sweep(YAW.replace("stop: 7, num: 5", "stop: 3.5, num: 1").replace("start: 3,", "start: 3.5,")), tmp_path
    )
    with pytest.raises(ConfigError, match=r"no value of c is in both; 5 values, c 3 to 7 in the first") as caught:
        compare_results(runs["yaw"], tmp_path)
    assert caught.value.exit_code == 2


def test_changed_cells_are_a_table(runs: dict[str, Path]) -> None:
    pair = [open_result(runs[name]) for name in ("yaw", "turned")]
    stream = io.StringIO()
    found = find_common(*pair)
    write_changes(found, stream)
    header, *rows = [line.split(",") for line in stream.getvalue().splitlines()]
    assert header[:4] == ["Omega1", "c", "region_a", "region_b"]
    assert header[4:] == [f"lyapunov_{k}_{side}" for side in "ab" for k in (1, 2, 3)]
    assert len(rows) == compare(found).changed
    for row in rows:
        i, j = list(pair[0]["Omega1"]).index(float(row[0])), list(pair[0]["c"]).index(float(row[1]))
        assert Region[row[2].upper()] == pair[0]["region"][i, j]
        assert float(row[4]) == pair[0]["lyapunov"][i, j, 0]


def test_the_verb_tells_it_in_80_columns(runs: dict[str, Path], tmp_path: Path) -> None:
    shutil.copytree(runs["yaw"], tmp_path / "a")
    shutil.copytree(runs["turned"], tmp_path / "b")
    done = _run("diff", "a", "b", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert max(len(line) for line in done.stdout.splitlines()) <= 80
    assert len(done.stdout.splitlines()) < 50
    for text in ("common   9 cells, of 45 and 12", "classify.errors: 3.0 -> 400.0", "integrate.dt: 0.02 -> 0.025"):
        assert text in done.stdout
    assert _on_a_terminal([*COMMAND, "diff", "a", "b"], tmp_path) == done.stdout

    told = json.loads(_run("diff", "a", "b", "--json", cwd=tmp_path).stdout)
    assert told == json.loads(json.dumps(compare_results(tmp_path / "a", tmp_path / "b").to_json()))
    table = _run("diff", "a", "b", "--csv", "-", cwd=tmp_path)
    assert len(table.stdout.splitlines()) == 1 + told["changed"]
    written = _run("diff", "a", "b", "--csv", "changed.csv", cwd=tmp_path)
    assert written.stdout == done.stdout
    assert (tmp_path / "changed.csv").read_text() == table.stdout


def _on_a_terminal(words: list[str], folder: Path) -> str:
    """Return what a command prints on a terminal."""
    child, main = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.execv(words[0], words)
    shown = b""
    while True:
        try:
            data = os.read(main, 4096)
        except OSError:
            break
        if not data:
            break
        shown += data
    os.waitpid(child, 0)
    return shown.decode().replace("\r\n", "\n")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("yaw", "starts"), "only results over the same axes can be compared"),
        (("yaw", "none"), "is not the folder of a run"),
        (("yaw",), "Missing argument 'B'"),
        (("yaw", "yaw", "--json", "--csv", "-"), "one of them"),
    ],
)
def test_mistakes_are_a_sentence(runs: dict[str, Path], arguments: tuple[str, ...], says: str) -> None:
    done = _run("diff", *arguments, cwd=runs["yaw"].parent)
    assert done.returncode == 2
    assert says in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_it_is_public() -> None:
    assert quavsweep.compare_results is compare_results
    assert quavsweep.Difference is Difference
