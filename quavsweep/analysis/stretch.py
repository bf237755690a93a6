"""Stretches of a line: where something holds, and where one thing gives way to another, whatever single points say."""

from __future__ import annotations

import numpy as np


def stretches(has: np.ndarray, gap: int = 1) -> list[tuple[int, int]]:
    """Return the first and last point of each stretch on which something holds at all points but a few.

    Parameters
    ----------
    has : (n,) bool
    gap : int
        Points without it that do not end a stretch, if the next has it again.
    """
    points = np.flatnonzero(has)
    if not points.size:
        return []
    parts = np.split(points, np.flatnonzero(np.diff(points) > gap + 1) + 1)
    return [(int(part[0]), int(part[-1])) for part in parts]


def best_interval(has: np.ndarray) -> tuple[int, int] | None:
    """Return the first and last point of the interval that tells best where something holds; None if nowhere.

    It is the one with the fewest mistakes: points inside without it, and points outside with it. Of several the first.

    Notes
    -----
    With +1 for a point that has it and -1 for one that has not, that is the interval of the largest sum (Kadane).
    """
    best, best_sum, first, total = None, 0, 0, 0
    for i, value in enumerate(np.where(has, 1, -1).tolist()):
        if total <= 0:
            first, total = i, 0
        total += value
        if total > best_sum:
            best, best_sum = (first, i), total
    return best


def end_range(has: np.ndarray, found: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return between which points the first and the last point of an interval may lie, the other end being held.

    Those intervals count that make no more mistakes than the best one and the standard deviation of that number.

    Parameters
    ----------
    has : (n,) bool
    found : (int, int)
        What `best_interval` finds.
    """
    first, last = found
    least = _mistakes(has, first, last)
    most = least + _deviation(least)
    left = [i for i in range(last + 1) if _mistakes(has, i, last) <= most]
    right = [i for i in range(first, len(has)) if _mistakes(has, first, i) <= most]
    return (left[0], left[-1]), (right[0], right[-1])


def _mistakes(has: np.ndarray, first: int, last: int) -> int:
    """Return the mistakes of an interval: points inside without it, and points outside with it."""
    inside = has[first : last + 1]
    return int(np.count_nonzero(has) - 2 * np.count_nonzero(inside) + inside.size)


def _deviation(mistakes: int) -> int:
    """Return the standard deviation of a number of mistakes, rounded down."""
    return int(np.sqrt(mistakes))


def best_border(before: np.ndarray, after: np.ndarray) -> int:
    """Return how many points lie before the border that tells best one thing from the next.

    Parameters
    ----------
    before, after : (n,) bool
        Whether each point has what is expected before the border, and behind it.

    Notes
    -----
    The border with the fewest mistakes: points before it without the one, points behind it without the other. Of
    several that are as good the middle one.
    """
    wrong = _wrong(before, after)
    ties = np.flatnonzero(wrong == wrong.min())
    return int(ties[ties.size // 2])


def border_range(before: np.ndarray, after: np.ndarray) -> tuple[int, int]:
    """Return between which borders the best one may lie, see `best_border` and `end_range`."""
    wrong = _wrong(before, after)
    least = int(wrong.min())
    good = np.flatnonzero(wrong <= least + _deviation(least))
    return int(good[0]), int(good[-1])


def _wrong(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the mistakes of each border, (n + 1,) int."""
    wrong_before = np.concatenate([[0], np.cumsum(~before)])
    wrong_after = np.concatenate([np.cumsum(~after[::-1])[::-1], [0]])
    return np.asarray(wrong_before + wrong_after)
