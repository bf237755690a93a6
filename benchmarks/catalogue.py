"""All rows, by suite, and how the command line names them."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks import accuracy, dimension, executor, growth, kernel, package, resources, sweep
from benchmarks.row import Row
from benchmarks.selection import named

ROWS: tuple[Row, ...] = (
    *kernel.ROWS,
    *package.ROWS,
    *accuracy.ROWS,
    *dimension.ROWS,
    *sweep.ROWS,
    *executor.ROWS,
    *resources.ROWS,
    *growth.ROWS,
)
SUITES = tuple(dict.fromkeys(row.suite for row in ROWS))


def select(names: Sequence[str]) -> list[Row]:
    """Return the rows of some suites, or single rows by key or the beginning of it, with the rows that they need.

    Raises
    ------
    KeyError
        With the first name that is neither.
    """
    chosen = named(names, {row.key: (row.suite,) for row in ROWS})
    chosen |= {row.needs for row in ROWS if row.key in chosen and row.needs}
    return [row for row in ROWS if row.key in chosen]


def listing() -> str:
    """Return the suites and their rows, one suite a line."""
    return "\n".join(f"  {suite}: {', '.join(row.key for row in ROWS if row.suite == suite)}" for suite in SUITES)
