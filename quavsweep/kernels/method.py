"""Explicit Runge-Kutta methods as tables that check their own order conditions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property

Tree = tuple["Tree", ...]  # a rooted tree is the sorted tuple of its root's subtrees


@dataclass(frozen=True)
class ButcherTable:
    """An explicit Runge-Kutta method; a table that does not have its order cannot exist.

    Parameters
    ----------
    name : str
        The name in configs.
    order : int
        The order that the table claims, checked on construction.
    a : tuple of tuples
        Row i holds the i coefficients of stage i (strictly lower triangle).
    b : tuple
        The weights.

    Raises
    ------
    ValueError
        If the shape is wrong, or a condition of the claimed order does not hold to 1e-14.

    References
    ----------
    .. [1] Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., Theorem II.2.13.
    """

    name: str
    order: int
    a: tuple[tuple[Fraction | float, ...], ...]
    b: tuple[Fraction | float, ...]

    def __post_init__(self) -> None:
        if len(self.a) != len(self.b) or any(len(row) != i for i, row in enumerate(self.a)):
            raise ValueError(
                f"{self.name}: {len(self.b)} weights do not fit stages of length {[len(r) for r in self.a]}"
            )
        if not self.b[-1]:
            raise ValueError(f"{self.name}: its last stage has no weight, so it does nothing")
        for size in range(1, self.order + 1):
            for tree in rooted_trees(size):
                miss = float(sum(w * v for w, v in zip(self.b, self._weights(tree), strict=True))) - 1 / density(tree)
                if abs(miss) > 1e-14:
                    raise ValueError(f"{self.name}: misses a condition of order {size} by {miss:.1e}")

    @property
    def stages(self) -> int:
        """Number of evaluations of the right-hand side."""
        return len(self.b)

    @cached_property
    def unit(self) -> Fraction | float:
        """The unit of time, in steps, in which most stages need no multiplication: 1/2 for RK4."""
        entries = Counter(x for row in self.a for x in row if x)
        value, count = max(entries.items(), key=lambda item: item[1], default=(Fraction(1), 0))
        return value if count > 1 else Fraction(1)

    def time_unit(self, dt: float) -> float:
        """Return the unit of time that a kernel's coefficients are given in, for steps of `dt`."""
        return float(self.unit) * dt

    @cached_property
    def stability(self) -> tuple[float, ...]:
        """Coefficients of the stability polynomial R(z), lowest power first."""
        values: list[Fraction | float] = [Fraction(1)] * self.stages
        polynomial = [1.0]
        for _ in range(self.stages):
            polynomial.append(float(sum(w * v for w, v in zip(self.b, values, strict=True))))
            values = [sum((x * values[j] for j, x in enumerate(row)), start=Fraction(0)) for row in self.a]
        return tuple(polynomial)

    def _weights(self, tree: Tree) -> list[Fraction | float]:
        """Return the stages' elementary weights of a tree's root."""
        values: list[Fraction | float] = [Fraction(1)] * self.stages
        for branch in tree:
            inner = self._weights(branch)
            sums = [sum((x * inner[j] for j, x in enumerate(row)), start=Fraction(0)) for row in self.a]
            values = [v * s for v, s in zip(values, sums, strict=True)]
        return values


@cache
def rooted_trees(size: int) -> tuple[Tree, ...]:
    """Return all rooted trees with `size` vertices."""
    return tuple(sorted(_forests(size - 1, size - 1)))


def _forests(size: int, largest: int) -> Iterator[Tree]:
    """Yield the sorted tuples of trees with `size` vertices in all and at most `largest` in each."""
    if size == 0:
        yield ()
        return
    for first in range(min(size, largest), 0, -1):
        for tree in rooted_trees(first):
            for rest in _forests(size - first, first):
                if not rest or (order(rest[0]), rest[0]) <= (first, tree):
                    yield (tree, *rest)


@cache
def order(tree: Tree) -> int:
    """Return the number of vertices of a tree."""
    return 1 + sum(order(branch) for branch in tree)


@cache
def density(tree: Tree) -> int:
    """Return gamma(t), the product over all vertices of the size of the subtree there."""
    return order(tree) * math.prod(density(branch) for branch in tree)


_HALF = Fraction(1, 2)

RK4 = ButcherTable(
    name="rk4",
    order=4,
    a=((), (_HALF,), (Fraction(0), _HALF), (Fraction(0), Fraction(0), Fraction(1))),
    b=(Fraction(1, 6), Fraction(1, 3), Fraction(1, 3), Fraction(1, 6)),
)

METHODS = {table.name: table for table in (RK4,)}
