"""The suite `growth`: what a cell and a tile cost as grids grow, and a plan for 1e9 cells drawn from it."""

from __future__ import annotations

import math
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
from benchmarks.growth_run import LATER, SHARDS, TINY, cheap_runs, omega_c_runs, real_shape
from benchmarks.growth_stage import peak
from benchmarks.protocol import Protocol
from benchmarks.row import Measurement, Row, at_least, at_most
from benchmarks.sweep import OMEGA_C
from quavsweep.config import load_sweep
from quavsweep.executor import Executor, Task, Threads
from quavsweep.executor.cluster import Cluster
from quavsweep.grid import Tile
from quavsweep.kernels.compiler import default_lanes
from quavsweep.plan import make_plan
from quavsweep.provenance import identify
from quavsweep.store import ShardSet
from quavsweep.tiling import choose_tile_cells

LARGE = 31623  # values per axis of 1e9 cells
ORDER_BYTES = 4300  # of what a worker is told of a tile of omega_c


def memory(stage: str, protocol: Protocol) -> Measurement:
    """Peak memory of a stage of the largest run [MB]."""
    peaks = {name: run[stage]["peak"] / 1e6 for name, run in cheap_runs(protocol.quick).items() if stage in run}
    note = "; ".join(f"{name}: {size:.0f} MB" for name, size in peaks.items())
    largest = [size for name, size in peaks.items() if name.endswith("full")][-1]
    return Measurement([largest], {"peak": list(peaks.values())}, "MB", note, {"peaks": peaks})


def consolidation(protocol: Protocol) -> Measurement:
    """Cells per second that become a result, of the cheap system and of omega_c."""
    cheap, real = cheap_runs(protocol.quick), omega_c_runs(protocol.quick)
    rates = {name: _cells(name) / run["consolidate"]["wall"] for name, run in cheap.items() if name != "tiny"}
    rates |= {
        f"omega_c {name}": math.prod(real_shape(protocol.quick)) / run["consolidate"]["wall"]
        for name, run in real.items()
    }
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
        cells = math.prod(real_shape(protocol.quick))
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
        run, identity, seconds = fabricate(Path(folder) / "run", sweep, SHARDS), identify(sweep), []
        for _ in range(samples):
            began = time.perf_counter()
            ShardSet.scan(run, sweep, identity)
            seconds.append(time.perf_counter() - began)
        tracemalloc.start()
        shards = ShardSet.scan(run, sweep, identity)
        tiles = [*map(shards.tile, range(len(shards.shards)))]
        size = tracemalloc.get_traced_memory()[0] / len(tiles)
        tracemalloc.stop()
    return seconds, size


def scan(protocol: Protocol) -> Measurement:
    """Time of the scan of 20,000 shards that a resumed run begins with [s]."""
    seconds, size = _scanned(protocol.samples)
    return Measurement(seconds, {"scan": seconds}, "s", f"{SHARDS:,} names and sizes; {size:.0f} bytes of memory each")


def nothing(order: bytes, stopped: Callable[[], bool]) -> None:
    """Do the work of an empty tile."""


def _nothing_of(tile: Tile) -> Task:
    return partial(nothing, bytes(ORDER_BYTES))


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
    note = "\n".join([*(f"{name:22} {text}" for name, text in table.items()), *(f"assumed: {a}" for a in ASSUMPTIONS)])
    detail: dict[str, Any] = {"table": table, "assumptions": ASSUMPTIONS, "measured": asdict(measured)}
    return Measurement([LARGE**2 * measured.core_seconds / 3600], note=note, detail=detail)


def _measured(protocol: Protocol) -> Measured:
    real, cells = omega_c_runs(protocol.quick), math.prod(real_shape(protocol.quick))
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


ROWS = (
    Row("bytes", "growth", "full evidence of omega_c", "B/cell", None, disk),
    Row("consolidate", "growth", "consolidation of omega_c", "cells/s", None, consolidation),
    *(
        Row(f"memory-{stage}", "growth", f"peak memory of {stage}", "MB", at_most(400), partial(memory, stage))
        for stage in LATER
    ),
    Row("verify", "growth", "verify, full evidence", "MB/s", at_least(200), verification),
    Row("scan", "growth", "scan of 20,000 shards", "s", at_most(1), scan),
    Row("tile-threads", "growth", "empty tile on threads", "ms", None, partial(tile, 0)),
    Row("tile-processes", "growth", "empty tile, 2 processes", "ms", None, partial(tile, 2)),
    Row("tile-tiny", "growth", "tile of 5 cells, all of it", "ms", None, tiny_tile),
    Row("plan", "growth", "1e9 cells", "core hours", None, plan),
)
