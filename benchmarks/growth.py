"""The suite `growth`: what a cell and a tile cost as grids grow, and a plan for 1e9 cells drawn from it."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import threading
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from typing import Any

from benchmarks.extrapolation import ASSUMPTIONS, Measured, rows
from benchmarks.fabricated import fabricate
from benchmarks.growth_stage import peak
from benchmarks.protocol import Protocol
from benchmarks.row import Measurement, Row, at_least, at_most
from benchmarks.sweep import OMEGA_C
from quavsweep.config import dump_config, load_sweep, parse_sweep
from quavsweep.executor import Executor, Task, Threads
from quavsweep.executor.cluster import Cluster
from quavsweep.grid import Tile
from quavsweep.kernels.compiler import default_lanes
from quavsweep.plan import make_plan
from quavsweep.provenance import identify
from quavsweep.store import ShardSet
from quavsweep.tiling import choose_tile_cells

# All cells end in a sink at once, with as much evidence as others: what is left is what a cell costs around its kernel.
CHEAP = """
name: growth
model: linear
initial: {x: 1.0, y: 1.0, z: 1.0}
axes: {re: {start: -1, stop: -0.3, num: 1000}, a: {start: -1, stop: -0.3, num: 1000}}
integrate: {method: rk4, dt: 0.02, transient: 8, duration: 24}
measures: {lyapunov: {exponents: 3, block: 25}}
"""
SHAPES = {10**4: (100, 100), 10**5: (400, 250), 10**6: (1000, 1000)}
LARGE = 31623  # values per axis of 1e9 cells
TINY = 5  # cells per tile
SHARDS = 20_000
EVIDENCE = ("full", "summary")
LATER = ("consolidate", "open", "status", "summary", "plot", "verify", "classify")
Stages = dict[str, dict[str, float]]


def _stages(folder: Path, config: str, tile_cells: int | None = None) -> Stages:
    """Run a sweep and everything that is done with a run, each in a fresh process; return what each took, and sizes."""
    folder.with_suffix(".yaml").write_text(config)
    keeps = parse_sweep(config).keeps_evidence
    took = {"run": _stage("run", folder, *([str(tile_cells)] if tile_cells else []))}
    shards = [path.stat().st_size for path in folder.glob("shards/*/*/*/*.h5")]
    took["disk"] = {"shards": len(shards), "shard_bytes": sum(shards), "result": (folder / "result.h5").stat().st_size}
    took |= {name: _stage(name, folder) for name in LATER if keeps or name != "classify"}
    subprocess.run(["rm", "-r", str(folder)], check=True)
    return took


def _stage(*words: str | Path) -> dict[str, float]:
    command = [sys.executable, "-m", "benchmarks.growth_stage", *map(str, words)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return dict(json.loads(done.stdout))


@cache
def cheap_runs(quick: bool) -> dict[str, Stages]:
    """Return what runs of the cheap system took, by cells and kind of evidence; the last one in tiny tiles."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for cells in list(SHAPES)[: 2 if quick else 3]:
            for evidence in EVIDENCE:
                name = f"{cells:,} {evidence}"
                found[name] = _stages(Path(folder) / "run", _cheap(SHAPES[cells], evidence))
        tiles = 1000 if quick else SHARDS
        found["tiny"] = _stages(Path(folder) / "run", _cheap((100, tiles * TINY // 100), "full"), TINY)
    return found


def _cheap(shape: tuple[int, int], evidence: str) -> str:
    changes = [f"axes.re.num={shape[0]}", f"axes.a.num={shape[1]}", f"evidence={evidence}"]
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(CHEAP)
        file.flush()
        return dump_config(load_sweep(Path(file.name), changes).canonical())


@cache
def omega_c_runs(quick: bool) -> dict[str, Stages]:
    """Return what omega_c itself took on a smaller grid, by kind of evidence."""
    shape = ("axes.Omega1.num=46", "axes.c.num=21") if quick else ("axes.Omega1.num=120", "axes.c.num=84")
    with tempfile.TemporaryDirectory() as folder:
        return {
            evidence: _stages(
                Path(folder) / "run", dump_config(load_sweep(OMEGA_C, [*shape, f"evidence={evidence}"]).canonical())
            )
            for evidence in EVIDENCE
        }


def memory(stage: str, protocol: Protocol) -> Measurement:
    """Peak memory of a stage of the largest run over that of the run with a tenth of the cells."""
    runs = {name: run[stage]["peak"] for name, run in cheap_runs(protocol.quick).items() if stage in run}
    full = [size for name, size in runs.items() if name.endswith("full")]
    note = "; ".join(f"{name}: {size / 1e6:.0f} MB" for name, size in runs.items())
    return Measurement([full[-1] / full[-2]], {"peak": list(runs.values())}, "bytes", note, {"peaks": runs})


def consolidation(protocol: Protocol) -> Measurement:
    """Cells per second that become a result, of the cheap system and of omega_c."""
    cheap, real = cheap_runs(protocol.quick), omega_c_runs(protocol.quick)
    rates = {name: _cells(name) / run["consolidate"]["wall"] for name, run in cheap.items() if name != "tiny"}
    rates |= {f"omega_c {name}": _real_cells(protocol.quick) / run["consolidate"]["wall"] for name, run in real.items()}
    note = "; ".join(f"{name}: {rate:,.0f}/s" for name, rate in rates.items())
    return Measurement([rates["omega_c full"]], {}, "", note, {"rates": rates, "cheap": cheap, "omega_c": real})


def disk(protocol: Protocol) -> Measurement:
    """Bytes per cell in shards and in the result."""
    sizes = {}
    for name, run in cheap_runs(protocol.quick).items():
        cells = _cells(name) if name != "tiny" else run["disk"]["shards"] * TINY
        sizes[name] = {key: run["disk"][key] / cells for key in ("shard_bytes", "result")} | {
            "shards": run["disk"]["shards"]
        }
    for name, run in omega_c_runs(protocol.quick).items():
        cells = _real_cells(protocol.quick)
        sizes[f"omega_c {name}"] = {key: run["disk"][key] / cells for key in ("shard_bytes", "result")} | {
            "shards": run["disk"]["shards"]
        }
    note = "; ".join(
        f"{name}: {size['shards']:.0f} shards, {size['shard_bytes']:.0f} and {size['result']:.0f} B"
        for name, size in sizes.items()
    )
    return Measurement([sizes["omega_c full"]["shard_bytes"]], {}, "", note, {"sizes": sizes})


def verification(protocol: Protocol) -> Measurement:
    """Megabytes of shards and result per second that `verify` checks, in the largest run."""
    run = [run for name, run in cheap_runs(protocol.quick).items() if name.endswith("full")][-1]
    size = run["disk"]["shard_bytes"] + run["disk"]["result"]
    return Measurement([size / run["verify"]["wall"] / 1e6], note=f"{size / 1e6:.0f} MB, read again from the cache")


@cache
def _scanned(samples: int) -> tuple[list[float], float]:
    """Return how long scans of 20,000 shards take [s], and the memory of a shard [bytes]."""
    sweep = load_sweep(OMEGA_C, [f"axes.Omega1.num={LARGE}", f"axes.c.num={LARGE}"])
    with tempfile.TemporaryDirectory() as folder:
        run, seconds = fabricate(Path(folder) / "run", sweep, SHARDS), []
        for _ in range(samples):
            began = time.perf_counter()
            ShardSet.scan(run, sweep, identify(sweep))
            seconds.append(time.perf_counter() - began)
        tracemalloc.start()
        shards = ShardSet.scan(run, sweep, identify(sweep))
        tiles = [*map(shards.tile, range(len(shards.shards)))]
        size = tracemalloc.get_traced_memory()[0] / len(tiles)
        tracemalloc.stop()
    return seconds, size


def scan(protocol: Protocol) -> Measurement:
    """Time of the scan of 20,000 shards that a resumed run begins with [s]."""
    seconds, size = _scanned(protocol.samples)
    return Measurement(seconds, {"scan": seconds}, "s", f"{SHARDS:,} names and sizes; {size:.0f} bytes of memory each")


def nothing(stopped: Callable[[], bool]) -> None:
    """Do the work of an empty tile."""


def _nothing_of(tile: Tile) -> Task:
    return nothing


def _per_tile(executor: Executor, tiles: int) -> float:
    """Return the time that an empty tile takes from order to receipt, many at a time [s]."""
    every = [Tile(i, i, i + 1) for i in range(tiles)]
    began = time.perf_counter()
    count = sum(receipt.error is None for receipt in executor.run(_nothing_of, every, threading.Event()))
    if count != tiles:
        raise RuntimeError(f"{count} of {tiles} empty tiles were done")
    return (time.perf_counter() - began) / tiles


@cache
def _per_empty_tile(processes: int, tiles: int, samples: int) -> list[float]:
    """Return times per empty tile [ms], on threads or on a cluster of processes."""
    if not processes:
        return [1e3 * _per_tile(Threads(2), tiles) for _ in range(samples)]
    with Cluster(processes=processes) as cluster:
        _per_tile(cluster, 10)
        return [1e3 * _per_tile(cluster, tiles) for _ in range(samples)]


def tile(processes: int, protocol: Protocol) -> Measurement:
    """Time per empty tile [ms]."""
    values = _per_empty_tile(processes, 500 if protocol.quick else 2000, protocol.samples)
    return Measurement(values, {"tile": values}, "ms")


def tiny_tile(protocol: Protocol) -> Measurement:
    """Time per tile of a run in tiles of five cells, all of it [ms]."""
    run = cheap_runs(protocol.quick)["tiny"]
    tiles = run["disk"]["shards"]
    note = f"{tiles:,.0f} tiles of {TINY} cells, 2 threads, each shard synced to the disk"
    return Measurement([1e3 * run["run"]["wall"] / tiles], note=note)


def plan(protocol: Protocol) -> Measurement:
    """Core hours of 1e9 cells of the kind of omega_c, with a table of the rest."""
    measured = _measured(protocol)
    table = dict(rows(measured, LARGE**2))
    note = "; ".join([*(f"{name}: {text}" for name, text in table.items()), *(f"assumed: {a}" for a in ASSUMPTIONS)])
    detail: dict[str, Any] = {"table": table, "assumptions": ASSUMPTIONS, "measured": asdict(measured)}
    return Measurement([LARGE**2 * measured.core_seconds / 3600], note=note, detail=detail)


def _measured(protocol: Protocol) -> Measured:
    real, cells = omega_c_runs(protocol.quick), _real_cells(protocol.quick)
    cheap = [run for name, run in cheap_runs(protocol.quick).items() if name.endswith("full")][-1]
    large = load_sweep(OMEGA_C, [f"axes.Omega1.num={LARGE}", f"axes.c.num={LARGE}"])
    seconds, size = _scanned(protocol.samples)
    full = real["full"]
    return Measured(
        tile_cells=choose_tile_cells(make_plan(large, default_lanes())),
        core_seconds=(full["run"]["cpu"] - full["consolidate"]["cpu"]) / cells,
        shard_bytes={name: run["disk"]["shard_bytes"] / cells for name, run in real.items()},
        result_bytes=full["disk"]["result"] / cells,
        consolidated={name: cells / run["consolidate"]["wall"] for name, run in real.items()},
        verified=1e6 * verification(protocol).value,
        hashed=cheap["disk"]["result"] / cheap["open"]["wall"],
        scanned=SHARDS / sorted(seconds)[len(seconds) // 2],
        driver_bytes=peak(),
        shard_memory=size,
        scheduled=1e3 / tile(2, protocol).value,
    )


def _cells(name: str) -> int:
    return int(name.split(maxsplit=1)[0].replace(",", ""))


def _real_cells(quick: bool) -> int:
    return 46 * 21 if quick else 120 * 84


ROWS = (
    Row("bytes", "growth", "full evidence of omega_c", "B/cell", None, disk),
    Row("consolidate", "growth", "consolidation of omega_c", "cells/s", None, consolidation),
    *(
        Row(f"memory-{stage}", "growth", f"memory of {stage}, x10 cells", "x", at_most(1.25), partial(memory, stage))
        for stage in LATER
    ),
    Row("verify", "growth", "verify, full evidence", "MB/s", at_least(200), verification),
    Row("scan", "growth", "scan of 20,000 shards", "s", at_most(1), scan),
    Row("tile-threads", "growth", "empty tile on threads", "ms", None, partial(tile, 0)),
    Row("tile-processes", "growth", "empty tile, 2 processes", "ms", None, partial(tile, 2)),
    Row("tile-tiny", "growth", "tile of 5 cells, all of it", "ms", None, tiny_tile),
    Row("plan", "growth", "1e9 cells", "core hours", None, plan),
)
