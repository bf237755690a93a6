"""Shards that are only names and sizes: sparse files as a run of so many tiles would leave them."""

from __future__ import annotations

import hashlib
from pathlib import Path

from quavsweep.config import Sweep
from quavsweep.provenance import identify
from quavsweep.store import RunFolder

CELLS = 4832  # of a tile, as configs/omega_c.yaml has over a large grid
BYTES = 7_700_000


def fabricate(folder: Path, sweep: Sweep, tiles: int) -> RunFolder:
    """Fill the folder of a run with that many names of shards; no byte of them is on the disk."""
    run, identity = RunFolder(folder), identify(sweep)
    stage = run.shards(identity.evidence, identity.toolchain) / f"0-{sweep.clock.steps}"
    stage.mkdir(parents=True)
    for index in range(tiles):
        digest = hashlib.sha256(index.to_bytes(8, "little")).hexdigest()
        with (stage / f"tile-{index:07d}.{CELLS}.{BYTES}.{digest}.h5").open("wb") as file:
            file.truncate(BYTES)
    return run
