"""The search for the nearest change along a line: what to ask next, given what was answered; it asks nobody itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

import numpy as np

INNER, OUTER = 0.99, 1.01  # of the distance: the two points that show it
FINE = 2e-3  # of the distance, to which an edge is narrowed before those two are tried
SECTIONS = 8  # into which a gap is cut at a time
HALVINGS = 40  # of the first step of a scan, below which a change counts as one at the base point itself


@dataclass(frozen=True)
class Found:
    """What a search along a line found; distances are from the base point, in the line's unit.

    Parameters
    ----------
    base : bool
        Whether the craft tumbles at the base point.
    distance : float, optional
        d: at `inner` the answer is that of the base point, at `outer` it is another. None if all points of the scan
        answer alike.
    inner, outer : float, optional
        0.99 d and 1.01 d, both asked. If the answer changes nearer than the search may go, it ends: the base point
        lies in or at a fractal boundary, `inner` is 0, and `outer` is d, a bound.
    """

    base: bool
    distance: float | None = None
    inner: float | None = None
    outer: float | None = None


Search = Generator[np.ndarray, np.ndarray, Found]


def nearest_change(stages: Sequence[np.ndarray], finest: float = 0.0, farthest: float = math.inf) -> Search:
    """Yield distances to ask about, get whether the craft tumbles there, and return the nearest change.

    Parameters
    ----------
    stages : sequence of (n,) float64
        The scan: distances above 0, ascending; a stage is asked only if those before it show no change.
    finest : float
        A distance that is not halved any more, as where numbers end; at least 2^-40 of the first step of the scan.
    farthest : float
        A distance beyond which nothing may be asked, as where the model ends.

    Notes
    -----
    Between two points that were asked anything may lie: where the boundary is fractal, the nearest change is the
    nearest that the scan sees. Its gap is cut into eight again and again, always kept where the change is nearest to
    the base point, until it is narrow. Then two distances are tried: the middle of the gap, and the one whose outer
    point is the change itself. If an inner point turns out to differ, the search goes on from there; each time that
    is nearer by 2 % or more, so it ends.
    """
    known: dict[float, bool] = {}
    for number, stage in enumerate(stages):
        yield from _ask(known, [0.0, *stage] if number == 0 else stage)
        if len(set(known.values())) > 1:
            break
    else:
        return Found(known[0.0])
    floor = max(finest, float(stages[0][0]) * 0.5**HALVINGS)
    while True:
        inner, outer = _gap(known)
        if outer <= floor:
            return Found(known[0.0], outer, 0.0, outer)
        if outer - inner > FINE * outer:
            yield from _ask(known, _cuts(inner, outer))
            continue
        middle = 0.5 * (inner + outer)
        pairs = [(middle, INNER * middle, OUTER * middle), (outer / OUTER, INNER * (outer / OUTER), outer)]
        pairs = [pair for pair in pairs if pair[2] <= farthest]
        yield from _ask(known, [distance for pair in pairs for distance in pair[1:]])
        for distance, near, far in pairs:
            if known[near] == known[0.0] != known[far] and _gap(known)[1] > near:
                return Found(known[0.0], distance, near, far)


def _ask(known: dict[float, bool], distances: Sequence[float] | np.ndarray) -> Generator[np.ndarray, np.ndarray, None]:
    """Ask about distances that are not known yet, and note the answers."""
    new = np.unique([distance for distance in map(float, distances) if distance not in known])
    if new.size:
        answers = yield new
        known.update(zip(new.tolist(), np.asarray(answers, dtype=bool).tolist(), strict=True))


def _gap(known: dict[float, bool]) -> tuple[float, float]:
    """Return the distance of the nearest change, behind that of the point before it."""
    ordered = sorted(known)
    first = next(i for i, distance in enumerate(ordered) if known[distance] != known[0.0])
    return ordered[first - 1], ordered[first]


def _cuts(inner: float, outer: float) -> np.ndarray:
    """Return distances inside a gap: evenly, or by halves where it begins at the base point."""
    if inner > 0:
        return np.linspace(inner, outer, SECTIONS + 1)[1:-1]
    return np.asarray(outer * 0.5 ** np.arange(SECTIONS - 1, 0, -1))


def run_searches(
    searches: Sequence[Search], ask: Callable[[list[tuple[int, np.ndarray]]], Sequence[np.ndarray]]
) -> list[Found]:
    """Run searches side by side and return what each found: a round asks the questions of all of them together.

    Parameters
    ----------
    searches : sequence of Search
    ask : callable
        Gets (number of the search, (n,) distances) of all that still ask, and returns an (n,) bool array for each.
    """
    found: dict[int, Found] = {}
    answers: list[tuple[int, np.ndarray | None]] = [(number, None) for number in range(len(searches))]
    while answers:
        asked = []
        for number, answer in answers:
            try:
                asked.append((number, searches[number].send(answer)))  # type: ignore[arg-type]
            except StopIteration as end:
                found[number] = end.value
        numbers = [number for number, _ in asked]
        answers = list(zip(numbers, ask(asked), strict=True)) if asked else []
    return [found[number] for number in range(len(searches))]
