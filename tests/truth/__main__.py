"""The table of truth: `python -m tests.truth [ROW...] [--quick] [--list] [--json FILE] [--out DIR]`."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from tests.truth.catalogue import listing, select
from tests.truth.laboratory import Laboratory
from tests.truth.report import record, summed_up, told
from tests.truth.row import Outcome, Row


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure rows and print them as they come; return 0 if all hold, 1 if one is missed, 2 if there is none such."""
    options = _parser().parse_args(arguments)
    if options.list:
        print(listing())
        return 0
    try:
        rows = select(options.rows)
    except KeyError as error:
        print(f"there is no row {error.args[0]}; there are", file=sys.stderr)
        print(listing(), file=sys.stderr)
        return 2
    outcomes = []
    with _folder(options.out) as folder:
        laboratory = Laboratory(folder, options.quick, options.workers)
        for row in rows:
            outcomes.append(run(row, laboratory))
            print(told(outcomes[-1]), flush=True)
            if options.json:
                options.json.write_text(json.dumps(record(outcomes, options.quick), indent=1) + "\n")
    print(summed_up(outcomes) + (" (QUICK: numbers too small to judge by)" if options.quick else ""))
    return 0 if all(outcome.holds for outcome in outcomes) else 1


def run(row: Row, laboratory: Laboratory) -> Outcome:
    """Measure a row; an error is the outcome of its row alone."""
    begin = time.perf_counter()
    try:
        claims, error = row.measure(laboratory), ""
    except Exception as raised:  # whatever goes wrong is a row that is missed, and the others are measured
        traceback.print_exc()
        claims, error = (), f"{type(raised).__name__}: {raised}"
    return Outcome(row, claims, time.perf_counter() - begin, error)


@contextmanager
def _folder(out: Path | None) -> Iterator[Path]:
    """Give the folder that was named, or one that is gone afterwards."""
    if out is not None:
        yield out
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.truth", description="How this engine is judged.")
    parser.add_argument("rows", nargs="*", metavar="ROW", help="keys of rows, or their beginning; default all")
    parser.add_argument("--quick", action="store_true", help="small numbers, to see that a row works")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all numbers, versions and commit")
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep the runs there; what is there is not run again")
    parser.add_argument("--workers", type=int, default=2, metavar="N", help="threads of a run (2)")
    parser.add_argument("--list", action="store_true", help="list the rows and what they cost")
    return parser


if __name__ == "__main__":
    sys.exit(main())
