"""The runs of the suite `growth`: sweeps of 1e4 to 1e6 cells, and what each stage of them takes in a fresh process."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from benchmarks.sweep import OMEGA_C
from quavsweep.config import dump_config, load_sweep, parse_sweep

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
TINY = 5  # cells per tile
SHARDS = 20_000
TINY_TILES = 5000
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
        tiles = 1000 if quick else TINY_TILES
        found["tiny"] = _stages(Path(folder) / "run", _cheap((100, tiles * TINY // 100), "full"), TINY)
    return found


def real_shape(quick: bool) -> tuple[int, int]:
    """Return the smaller grid of omega_c."""
    return (46, 21) if quick else (160, 126)


def _cheap(shape: tuple[int, int], evidence: str) -> str:
    changes = [f"axes.re.num={shape[0]}", f"axes.a.num={shape[1]}", f"evidence={evidence}"]
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(CHEAP)
        file.flush()
        return dump_config(load_sweep(Path(file.name), changes).canonical())


@cache
def omega_c_runs(quick: bool) -> dict[str, Stages]:
    """Return what omega_c itself took on a smaller grid, by kind of evidence."""
    shape = [f"axes.{name}.num={n}" for name, n in zip(("Omega1", "c"), real_shape(quick), strict=True)]
    with tempfile.TemporaryDirectory() as folder:
        return {
            evidence: _stages(
                Path(folder) / "run", dump_config(load_sweep(OMEGA_C, [*shape, f"evidence={evidence}"]).canonical())
            )
            for evidence in EVIDENCE
        }
