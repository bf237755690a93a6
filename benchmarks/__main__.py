"""The benchmark suite: `python -m benchmarks [SUITE or row]... [--quick] [--json FILE] [--plot FILE] [--list]`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from threadpoolctl import threadpool_limits

from benchmarks.catalogue import SUITES, listing, select
from benchmarks.picture import draw
from benchmarks.protocol import FULL, QUICK, MissingError, Protocol
from benchmarks.report import record, table
from benchmarks.row import Outcome, Row, verdict


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print the table, write what was asked for; return the exit code."""
    options = _parser().parse_args(arguments)
    if options.list:
        print(listing())
        return 0
    try:
        rows = select(options.names)
    except KeyError as error:
        print(f"there is no suite {error.args[0]}; there are {', '.join(SUITES)}, and their rows:", file=sys.stderr)
        print(listing(), file=sys.stderr)
        return 2
    protocol = QUICK if options.quick else FULL
    with threadpool_limits(1):
        outcomes = run(rows, protocol)
    print(table(outcomes, protocol))
    if options.json:
        options.json.write_text(json.dumps(record(outcomes, protocol), indent=1) + "\n")
    if options.plot:
        draw(outcomes, options.plot, protocol)
    return 1 if any(outcome.verdict == "failed" for outcome in outcomes) else 0


def run(rows: Sequence[Row], protocol: Protocol) -> list[Outcome]:
    """Measure rows one after the other; a missing peer or compiler, or an error, is the outcome of its row alone."""
    done: dict[str, Outcome] = {}
    for row in rows:
        print(f"{row.suite}: {row.title} ...", file=sys.stderr, flush=True)
        try:
            measurement = row.measure(protocol)
        except MissingError as error:
            done[row.key] = Outcome(row, None, "missing", str(error))
        except Exception as error:  # a peer may raise anything; the other rows are measured all the same
            done[row.key] = Outcome(row, None, "failed", f"{type(error).__name__}: {error}")
        else:
            done[row.key] = Outcome(row, measurement, verdict(row, measurement, done))
    return list(done.values())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Every figure, measured side by side.")
    parser.add_argument("names", nargs="*", metavar="SUITE", help=f"{', '.join(SUITES)}, or a row; default all")
    parser.add_argument("--quick", action="store_true", help="fewer and shorter samples, thumbnails of sweeps")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every sample, versions and commit")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the figures, PNG or PDF")
    parser.add_argument("--list", action="store_true", help="list the suites and their rows")
    return parser


if __name__ == "__main__":
    sys.exit(main())
