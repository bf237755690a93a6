"""F38: 20,000 shards: a scan asks for names and sizes alone, and a check of all bytes keeps up with a disk."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.fabricated import CELLS, fabricate
from quavsweep.config import Sweep, dump_config, load_sweep, parse_sweep
from quavsweep.errors import DamageError
from quavsweep.provenance import identify
from quavsweep.store import RunFolder, ShardSet
from quavsweep.sweep import run_sweep
from quavsweep.verify import verify_folder
from tests.faults.arena import Arena
from tests.faults.fault import Case, Fault

Clock = Callable[[], float]
OMEGA_C = Path(__file__).parents[2] / "configs" / "omega_c.yaml"
SHARDS = 20_000
SCAN_SECONDS, VERIFY_RATE = 1.0, 200e6
TINY = """
name: tiny
model: linear
initial: {x: 1.0, y: 1.0, z: 1.0}
axes: {re: {start: -1, stop: -0.3, num: 200}, a: {start: -1, stop: -0.3, num: 200}}
integrate: {method: rk4, dt: 0.02, transient: 8, duration: 24}
"""


def _scanned(run: RunFolder, sweep: Sweep, clock: Clock) -> str:
    """Return what is wrong with the median time of several scans."""
    identity, seconds = identify(sweep), []
    for _ in range(5):
        began = clock()
        found = len(ShardSet.scan(run, sweep, identity).shards)
        seconds.append(clock() - began)
        if found != SHARDS:
            return f"{found} shards were found"
    middle = statistics.median(seconds)
    return "" if middle < SCAN_SECONDS else f"a scan took {middle:.2f} s"


def _names(folder: Path, clock: Clock) -> str:
    """Scan names and sizes that have no content; it is missed when it is first used."""
    sweep = load_sweep(OMEGA_C, ["axes.Omega1.num=10000", "axes.c.num=10000"])
    run = fabricate(folder, sweep, SHARDS)
    note = _scanned(run, sweep, clock)
    try:
        ShardSet.scan(run, sweep, identify(sweep)).read(SHARDS // 2, {})
    except DamageError:
        return note
    return "zeros were taken for evidence"


def _checked(folder: Path, clock: Clock) -> str:
    """Verify a folder with the tiles of a large sweep."""
    sweep = load_sweep(OMEGA_C)
    run = RunFolder(folder)
    shards = ShardSet.scan(run, sweep, identify(sweep), CELLS)
    empty = {tile.index: shards.read(tile.index, {}) for tile in shards.missing()}
    written = [shards.write(shards.tile(index), evidence, 0, shards.end) for index, evidence in empty.items()]
    run.write_config(dump_config(sweep.canonical()))
    rates = []
    for _ in range(3):
        began = clock()
        verdict = verify_folder(folder)
        rates.append(sum(shard.size for shard in written) / (clock() - began))
        if verdict.damaged or verdict.shards != len(written):
            return f"{verdict}"
    rate = statistics.median(rates)
    return "" if rate >= VERIFY_RATE else f"{rate / 1e6:.0f} MB/s were verified"


def _real(folder: Path, clock: Clock) -> str:
    """Scan and verify a run in as many tiles."""
    sweep = parse_sweep(TINY)
    run_sweep(sweep, folder, tile_cells=sweep.grid.size // SHARDS)
    note = _scanned(RunFolder(folder), sweep, clock)
    verdict = verify_folder(folder)
    return note or (f"{verdict}" if verdict.damaged or verdict.missing else "")


CASES: dict[str, Callable[[Path, Clock], str]] = {"names": _names, "verify": _checked, "real": _real}


def _attack(arena: Arena, cases: int) -> Iterator[Case]:
    # Tests run beside others, so that a push counts the time of the processor alone.
    clock = time.monotonic if cases >= len(CASES) else time.process_time
    for kind, _ in zip(CASES, range(cases), strict=False):
        with arena.place() as place:
            note = CASES[kind](place / "run", clock)
            yield Case(not note, note and f"{kind}: {note}", "taken for" in note, (kind,))


FAULTS = (Fault("F38", "20,000 shards: scan, verify, hash when first used", 2, 3, _attack),)
