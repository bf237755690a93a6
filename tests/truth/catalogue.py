"""All rows, and how the command line names them."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.selection import named
from tests.truth import (
    certificate,
    coverage,
    cycle,
    false_answer,
    half_step,
    horizon,
    lifetime,
    linear,
    lorenz,
    margin,
    published,
    stop_early,
    unstable,
)
from tests.truth.row import Row

ROWS: tuple[Row, ...] = (
    *coverage.ROWS,
    *published.ROWS,
    *unstable.ROWS,
    *linear.ROWS,
    *lorenz.ROWS,
    *certificate.ROWS,
    *half_step.ROWS,
    *false_answer.ROWS,
    *horizon.ROWS,
    *cycle.ROWS,
    *stop_early.ROWS,
    *lifetime.ROWS,
    *margin.ROWS,
)


def select(names: Sequence[str]) -> list[Row]:
    """Return rows by key or the beginning of it, all if no name is given.

    Raises
    ------
    KeyError
        With the first name that is none.
    """
    chosen = named(names, {row.key: () for row in ROWS})
    return [row for row in ROWS if row.key in chosen]


def listing() -> str:
    """Return the rows, one a line, with what they cost."""
    return "\n".join(f"  {row.key:22} {row.title} ({row.cost})" for row in ROWS)
