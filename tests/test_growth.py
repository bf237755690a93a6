"""Growth: what is held in memory does not grow with the grid, and no tile costs more because there are more of them."""

from __future__ import annotations

import threading
import tracemalloc
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from benchmarks.growth import LARGE
from quavsweep.codes import REGION
from quavsweep.config import Sweep, dump_config, parse_sweep
from quavsweep.executor import Receipt, TaskOf
from quavsweep.grid import Tile
from quavsweep.overview import Lookout
from quavsweep.plot import draw, make_figure
from quavsweep.plot.thin import MOST
from quavsweep.provenance import identify
from quavsweep.result import Result, open_result
from quavsweep.store import Part, RunFolder, ShardSet, Stored, Variables, code_counts, write_copy
from quavsweep.store import shard_set as shard_set_module
from quavsweep.store.outcome import write_outcome
from quavsweep.summary import summarise
from quavsweep.sweep import run_sweep
from quavsweep.work import Done, Errand

LINEAR = """
name: linear
model: linear
initial: {x: 1.0, y: 1.0, z: 1.0}
axes:
  re: {start: -1, stop: -0.3, num: RE}
  a: {start: -1, stop: -0.3, num: A}
integrate: {method: rk4, dt: 0.02, transient: 8, duration: 24}
"""


def _linear(re: int, a: int) -> Sweep:
    return parse_sweep(LINEAR.replace("RE", str(re)).replace("A}", f"{a}}}"))


def _imagined(n: int, most: int) -> Result:
    """Return a result over n x n cells that are nowhere, and refuse to give more than so many numbers at once."""
    sweep = _linear(n, n)
    coordinates = {axis.name: np.array(axis.values) for axis in sweep.grid.axes}

    def read(name: str, part: Part) -> np.ndarray:
        if name in coordinates:
            return coordinates[name][part]
        rows, columns = (np.arange(n)[own] for own in (*part, slice(None), slice(None))[:2])
        assert rows.size * columns.size <= most, f"{rows.size} x {columns.size} numbers of {name}"
        codes = 1 + (rows[:, None] // 1000 + columns // 1000) % 2
        return codes.astype(np.int8)

    dims = {"region": ("re", "a"), "status": ("re", "a"), **{name: (name,) for name in coordinates}}
    return Result(sweep, Stored(Variables(tuple(dims), read), dims, {name: {} for name in dims}, {}))


@pytest.fixture
def traced() -> Iterator[Callable[[], int]]:
    """Return a function that gives the most memory that was held since it was last asked."""
    tracemalloc.start()

    def peak() -> int:
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.reset_peak()
        return size

    yield peak
    tracemalloc.stop()


def test_a_map_of_1e9_cells_reads_and_draws_a_few_of_them(tmp_path: Path) -> None:
    result = _imagined(LARGE, MOST[2] ** 2)
    figure = make_figure(result)
    (mesh,) = (mesh for mesh in figure.findobj(QuadMesh) if mesh.get_visible())
    step = -(-LARGE // MOST[2])
    side = -(-(LARGE - (LARGE - 1) % step // 2) // step)
    assert np.asarray(mesh.get_array()).shape == (side, side)
    assert f"{side:,} of {LARGE:,} x {side:,} of {LARGE:,}" in figure.get_suptitle()
    first = (LARGE - 1) % step // 2
    assert np.asarray(mesh.get_array())[5, 7] == 1 + ((first + 5 * step) // 1000 + (first + 7 * step) // 1000) % 2
    assert draw([result, result], tmp_path / "both.png").stat().st_size > 1000


def test_what_fits_into_a_figure_is_drawn_whole() -> None:
    figure = make_figure(_imagined(300, 300 * 300))
    (mesh,) = (mesh for mesh in figure.findobj(QuadMesh) if mesh.get_visible())
    assert np.asarray(mesh.get_array()).shape == (300, 300)
    assert not figure.get_suptitle()


def test_codes_are_counted_by_blocks() -> None:
    result = _imagined(3000, 2**20)
    whole = 1 + (np.arange(3000)[:, None] // 1000 + np.arange(3000) // 1000) % 2
    assert result.complete
    np.testing.assert_array_equal(
        code_counts(result.stored, "region", REGION), np.bincount(whole.ravel(), minlength=len(REGION))
    )
    assert summarise(result).regions == {"sink": 5_000_000, "periodic": 4_000_000}


def test_consolidation_and_readers_hold_no_more_of_a_larger_grid(tmp_path: Path, traced: Callable[[], int]) -> None:
    peaks = []
    for re in (60, 60, 600):  # the first warms up
        sweep, run = _linear(re, 400), RunFolder(tmp_path / str(re))
        shards = ShardSet.scan(run, sweep, identify(sweep), 4000)
        run.write_config(dump_config(sweep.canonical()))
        traced()
        write_outcome(run.result, shards, {}, lambda: False)
        peaks.append([traced()])
        overview = Lookout.of(run.path).look()
        peaks[-1].append(traced())
        result = open_result(run.path)
        assert not result.complete
        assert summarise(result).regions == {"none": re * 400} == overview.regions
        peaks[-1].append(traced())
        write_copy(result.stored, ["re", "a", "region"], tmp_path / "copy.nc")
        peaks[-1].append(traced())
    _, small, large = peaks
    assert all(b < a + 4e6 for a, b in zip(small, large, strict=True)), (small, large)
    assert max(large) < 80e6


def test_a_worker_that_is_told_its_shards_lists_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = _linear(4, 4)
    run_sweep(sweep, tmp_path, tile_cells=4)
    shards = ShardSet.scan(RunFolder(tmp_path), sweep, identify(sweep))
    monkeypatch.setattr(shard_set_module, "scan_shards", lambda *_: pytest.fail("the folder was listed"))
    own = ShardSet(shards.folder, sweep, shards.identity, 4)
    own.find(2, shards.names(2))
    assert own.shards == {2: shards.shards[2]}
    own.find(3, ["0-1600/tile-0000003.4.1.not-a-digest.h5", shards.names(1)[0].replace("tile-", "tile-9")])
    assert own.shards == {2: shards.shards[2]}


class Forgetful:
    """An executor that loses the first receipt of each tile, as with a worker that dies."""

    def __init__(self) -> None:
        self.known: dict[int, list[tuple[str, ...] | None]] = {}

    def run(self, task_of: TaskOf, tiles: Sequence[Tile], stop: threading.Event) -> Iterator[Receipt]:
        """Do each tile twice."""
        for tile in tiles:
            errands = [task_of(tile), task_of(tile)]
            assert all(isinstance(errand, Errand) for errand in errands)
            self.known[tile.index] = [errand.known for errand in errands if isinstance(errand, Errand)]
            first, second = (errand(stop.is_set) for errand in errands)
            assert isinstance(first, Done)
            assert second.steps == 0 < first.steps
            yield Receipt(tile, second)


def test_only_a_tile_that_is_lost_is_looked_for_in_the_folder(tmp_path: Path) -> None:
    executor, sweep = Forgetful(), _linear(4, 4)
    result = run_sweep(sweep, tmp_path / "a", executor=executor, tile_cells=8)
    assert executor.known == {0: [(), None], 1: [(), None]}
    assert result.read_bytes() == run_sweep(sweep, tmp_path / "b").read_bytes()
