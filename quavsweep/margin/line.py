"""Lines through parameter space: all that are asked about are scanned and narrowed together, run by run."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from quavsweep.margin.direction import Way
from quavsweep.margin.finding import Line, Side
from quavsweep.margin.probe import Prober
from quavsweep.margin.search import Found, nearest_change, run_searches

WAYS = (-1, 1)
RESOLVED = 2.0**8  # spacings of the numbers at the base value; nearer, 0.99 d and 1.01 d are not told apart well


def find_lines(ways: Sequence[Way], stages: Sequence[Sequence[float]], prober: Prober) -> list[Line]:
    """Return what was found along directions.

    Parameters
    ----------
    ways : sequence of Way
        Two for each direction, down and up.
    stages : sequence of sequence of float
        For each way the shares of its scan at which a stage of it ends; a stage is run only if there was no change.
    prober : Prober
    """
    searches = [
        nearest_change(
            _cut(way.scan, shares),
            RESOLVED * math.ulp(way.direction.base),
            way.limit if way.ended_by else math.inf,
        )
        for way, shares in zip(ways, stages, strict=True)
    ]

    def ask(questions: Sequence[tuple[int, np.ndarray]]) -> list[np.ndarray]:
        wanted = [[ways[number].point(distance) for distance in asked.tolist()] for number, asked in questions]
        prober.ask([point for points in wanted for point in points])
        return [np.array([prober.at(point).answer.tumbles for point in points]) for points in wanted]

    sides = [_side(way, found, prober) for way, found in zip(ways, run_searches(searches, ask), strict=True)]
    bases = [prober.at(way.point(0.0)) for way in ways[::2]]
    pairs = zip(bases, sides[::2], sides[1::2], strict=True)
    return [Line(below.way.direction, base, (below, above)) for base, below, above in pairs]


def _cut(scan: Sequence[float], shares: Sequence[float]) -> list[np.ndarray]:
    """Return the stages of a scan that end at some shares of it."""
    ends = [0, *(math.ceil(share * len(scan)) for share in shares)]
    return [np.asarray(scan[begin:end]) for begin, end in itertools.pairwise(ends)]


def _side(way: Way, found: Found, prober: Prober) -> Side:
    """Return what a search found, with the runs that show it."""
    inner, outer = (None if x is None else prober.at(way.point(x)) for x in (found.inner, found.outer))
    scan = tuple((x, prober.at(way.point(x))) for x in way.scan if prober.knows(way.point(x)))
    return Side(way, found.distance, inner, outer, scan, found.inner == 0.0)
