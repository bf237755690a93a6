"""The attacks: `python -m tests.faults [KEY...] [--push] [--cases N] [--seed N] [--json FILE] [--table] [--list]`."""

from __future__ import annotations

import argparse
import os
import random
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from tests.faults.arena import Arena
from tests.faults.catalogue import listing, select
from tests.faults.fault import Fault, Tally
from tests.faults.record import HEAD, add, read, table, told

RECORD = Path(__file__).parents[2] / "results" / "faults.json"


def main(arguments: Sequence[str] | None = None) -> int:
    """Make faults and print a row for each; return 0 if all promises held, 1 if one did not, 2 for a wrong key."""
    options = _parser().parse_args(arguments)
    if options.list or options.table:
        print(table(read(options.json)) if options.table else listing())
        return 0
    try:
        faults = select(options.keys)
    except KeyError as error:
        print(f"there is no fault {error.args[0]}; there are\n{listing()}", file=sys.stderr)
        return 2
    print(f"seed {options.seed}\n{HEAD}", flush=True)
    tallies = []
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault("QUAVSWEEP_CACHE", f"{folder}/cache")
        for fault in faults:
            cases = options.cases or (fault.push if options.push else fault.demand)
            if not cases:
                continue
            tallies.append(run(fault, Path(folder), cases, options.seed))
            print(told(tallies[-1]), flush=True)
            add(options.json, tallies[-1:], options.seed, options.push)
    missed = [tally.fault.key for tally in tallies if not tally.holds]
    seconds = sum(tally.seconds for tally in tallies)
    print(f"{len(tallies) - len(missed)} of {len(tallies)} hold, {seconds:.0f} s" + f"; not: {missed}" * bool(missed))
    return 1 if missed else 0


def run(fault: Fault, folder: Path, cases: int, seed: int) -> Tally:
    """Make a fault so often."""
    begin = time.monotonic()
    place = folder / fault.key
    place.mkdir()
    tally = Tally(fault).count(fault.attack(Arena(place, random.Random(f"{seed} {fault.key}")), cases))
    tally.seconds = time.monotonic() - begin
    return tally


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description="How the promises are attacked.")
    parser.add_argument("keys", nargs="*", metavar="KEY", help="faults, as F01; default all")
    parser.add_argument("--push", action="store_true", help="as few cases as every run of the tests makes")
    parser.add_argument("--cases", type=int, metavar="N", help="so many cases of each")
    parser.add_argument("--seed", type=int, default=time.time_ns() // 10**6, metavar="N", help="default: the time")
    parser.add_argument("--json", type=Path, default=RECORD, metavar="FILE", help="add to it (results/faults.json)")
    parser.add_argument("--table", action="store_true", help="print the table of all that the file records")
    parser.add_argument("--list", action="store_true", help="list the faults with both numbers of cases")
    return parser


if __name__ == "__main__":
    sys.exit(main())
