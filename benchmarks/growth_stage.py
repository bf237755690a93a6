"""One stage of a run in a process of its own: `python -m benchmarks.growth_stage STAGE FOLDER [TILE_CELLS]`.

Prints its seconds, those of the processor, and the peak of the process's memory, as JSON.
"""

from __future__ import annotations

import json
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path

from quavsweep.conductor import consolidate
from quavsweep.config import load_sweep
from quavsweep.overview import Lookout
from quavsweep.plot import draw
from quavsweep.progress import Progress
from quavsweep.provenance import identify
from quavsweep.result import open_result
from quavsweep.store import Failures, RunFolder, ShardSet
from quavsweep.summary import summarise
from quavsweep.sweep import reclassify, run_sweep
from quavsweep.verify import verify_folder


def run(folder: Path, tile_cells: int | None) -> None:
    """Run the sweep of `config.yaml` beside the folder from scratch."""
    run_sweep(load_sweep(folder.with_suffix(".yaml")), folder, tile_cells=tile_cells)


def _consolidate(folder: Path, tile_cells: int | None) -> None:
    own = RunFolder(folder)
    own.result.unlink()
    sweep = load_sweep(own.config)
    shards = ShardSet.scan(own, sweep, identify(sweep))
    failures = Failures.scan(own, shards.identity, shards.tile_cells)
    consolidate(own, shards, failures, lambda: False, Progress(0, 0))


STAGES: dict[str, Callable[[Path, int | None], object]] = {
    "run": run,
    "consolidate": _consolidate,
    "open": lambda folder, _: open_result(folder).complete,
    "status": lambda folder, _: Lookout.of(folder).look(),
    "summary": lambda folder, _: summarise(open_result(folder)),
    "plot": lambda folder, _: draw(open_result(folder), folder / "map.png"),
    "verify": lambda folder, _: verify_folder(folder),
    "classify": lambda folder, _: reclassify(folder, ["classify.errors=4"]),
}


def peak() -> int:
    """Return the most memory that this process has held [bytes]; that of the parent, as rusage tells, is not in it."""
    found = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())
    return int(found[1]) * 1024 if found else 0


def main() -> None:
    """Do the stage and print what it took."""
    stage, folder = STAGES[sys.argv[1]], Path(sys.argv[2])
    wall, cpu = time.perf_counter(), time.process_time()
    stage(folder, int(sys.argv[3]) if sys.argv[3:] else None)
    took = {"wall": time.perf_counter() - wall, "cpu": time.process_time() - cpu, "peak": peak()}
    print(json.dumps(took))


if __name__ == "__main__":
    main()
