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
        known: dict[Tree, list[Fraction | float]] = {}
        for size in range(1, self.order + 1):
            for tree in rooted_trees(size):
                values = self._weights(tree, known)
                miss = float(sum(w * v for w, v in zip(self.b, values, strict=True) if w)) - 1 / density(tree)
                if abs(miss) > 1e-14:
                    raise ValueError(f"{self.name}: misses a condition of order {size} by {miss:.1e}")

    @property
    def stages(self) -> int:
        """Number of evaluations of the right-hand side."""
        return len(self.b)

    @cached_property
    def nodes(self) -> tuple[Fraction | float, ...]:
        """Where in the step each stage lies, c_i: the sum of its row."""
        return tuple(sum(row, start=Fraction(0)) for row in self.a)

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
        values: list[Fraction | float] = [1] * self.stages
        polynomial = [1.0]
        for _ in range(self.stages):
            polynomial.append(float(sum(w * v for w, v in zip(self.b, values, strict=True))))
            values = [sum((x * values[j] for j, x in enumerate(row)), start=0) for row in self.a]
        return tuple(polynomial)

    def _weights(self, tree: Tree, known: dict[Tree, list[Fraction | float]]) -> list[Fraction | float]:
        """Return the stages' elementary weights of a tree's root: those of its branches, multiplied."""
        if tree not in known:
            values: list[Fraction | float] = [1] * self.stages
            if tree:
                inner = self._weights(tree[-1], known)
                rest = self._weights(tree[:-1], known)
                sums = (sum((x * inner[j] for j, x in enumerate(row) if x), start=0) for row in self.a)
                values = [v * s for v, s in zip(rest, sums, strict=True)]
            known[tree] = values
        return known[tree]


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

# P. J. Prince, J. R. Dormand, J. Comput. Appl. Math. 7, 67 (1981), with the coefficients of Hairer, Norsett, Wanner,
# Solving Ordinary Differential Equations I, 2nd ed., II.5 (DOP853); only the method of order 8, without its estimates.
DP8 = ButcherTable(
    name="dp8",
    order=8,
    a=(
        (),
        (0.05260015195876773,),
        (0.0197250569845379, 0.0591751709536137),
        (0.02958758547680685, 0, 0.08876275643042054),
        (0.2413651341592667, 0, -0.8845494793282861, 0.924834003261792),
        (0.037037037037037035, 0, 0, 0.17082860872947386, 0.12546768756682242),
        (0.037109375, 0, 0, 0.17025221101954405, 0.06021653898045596, -0.017578125),
        (
            0.03709200011850479,
            0,
            0,
            0.17038392571223998,
            0.10726203044637328,
            -0.015319437748624402,
            0.008273789163814023,
        ),
        (
            0.6241109587160757,
            0,
            0,
            -3.3608926294469414,
            -0.868219346841726,
            27.59209969944671,
            20.154067550477894,
            -43.48988418106996,
        ),
        (
            0.47766253643826434,
            0,
            0,
            -2.4881146199716677,
            -0.590290826836843,
            21.230051448181193,
            15.279233632882423,
            -33.28821096898486,
            -0.020331201708508627,
        ),
        (
            -0.9371424300859873,
            0,
            0,
            5.186372428844064,
            1.0914373489967295,
            -8.149787010746927,
            -18.52006565999696,
            22.739487099350505,
            2.4936055526796523,
            -3.0467644718982196,
        ),
        (
            2.273310147516538,
            0,
            0,
            -10.53449546673725,
            -2.0008720582248625,
            -17.9589318631188,
            27.94888452941996,
            -2.8589982771350235,
            -8.87285693353063,
            12.360567175794303,
            0.6433927460157636,
        ),
    ),
    b=(
        0.054293734116568765,
        0,
        0,
        0,
        0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ),
)

METHODS = {table.name: table for table in (RK4, DP8)}
