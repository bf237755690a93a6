"""Attractors at a parameter point: the certified ends of several starts, put together where they are the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MOST = 16  # attractors of a table
TOLERANCE = 1e-5  # points are the same that differ by less, of the largest coordinate among them
OTHER = -1  # the number of an attractor that the table has no room for


@dataclass(frozen=True)
class Attractors:
    """A table of attractors.

    Parameters
    ----------
    kind : (m,) int
    point : (m, D) float64
        A point on each. Sinks come before cycles, so that a cycle that appears renumbers no sink; either in ascending
        order of the points.
    count : (m,) int
        Starts that end there.
    first : (m,) int
        The first of these starts.
    number : (n,) int
        Of each start the number of its attractor, from 1; 0 for none, -1 for one that the table has no room for.
    """

    kind: np.ndarray
    point: np.ndarray
    count: np.ndarray
    first: np.ndarray
    number: np.ndarray


def find_attractors(kind: np.ndarray, point: np.ndarray, most: int = MOST) -> Attractors:
    """Return the attractors in which starts end.

    Parameters
    ----------
    kind : (n,) int
        Of each start's end, 0 where nothing is certified.
    point : (n, D) float64
        A point on its attractor, the same one for all starts but for rounding; mirror images have different ones.
    most : int
        Attractors at most; those with most starts are kept.

    Returns
    -------
    Attractors
        Ordered by kind, then by the points' coordinates, the first coordinate first.
    """
    known = (kind != 0) & np.isfinite(point).all(axis=1)
    number = np.where(known, OTHER, 0)
    scale = float(np.abs(point[known]).max(initial=0.0)) or 1.0
    found: list[int] = []
    sizes: list[int] = []
    left = np.flatnonzero(known)
    while left.size and len(found) < 4 * most:
        lead = left[0]
        apart = np.abs(point[left] - point[lead]).max(axis=1)
        same = (kind[left] == kind[lead]) & (apart <= TOLERANCE * scale)
        number[left[same]] = len(found) + 1
        found.append(int(lead))
        sizes.append(int(same.sum()))
        left = left[~same]
    first, count = np.array(found, dtype=int), np.array(sizes, dtype=int)
    kept = np.sort(np.argsort(-count, kind="stable")[:most])
    rounded = np.round(point[first[kept]] / (TOLERANCE * scale))
    order = kept[np.lexsort([*rounded.T[::-1], kind[first[kept]]])] if kept.size else kept
    names = np.full(len(first) + 1, OTHER)
    names[order + 1] = np.arange(1, len(order) + 1)
    number = np.where(number > 0, names[number], number)
    return Attractors(kind[first[order]], point[first[order]], count[order], first[order], number)
