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
    wrong_before = np.concatenate([[0], np.cumsum(~before)])
    wrong_after = np.concatenate([np.cumsum(~after[::-1])[::-1], [0]])
    wrong = wrong_before + wrong_after
    ties = np.flatnonzero(wrong == wrong.min())
    return int(ties[ties.size // 2])
