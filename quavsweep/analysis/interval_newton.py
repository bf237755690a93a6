"""All equilibria in a box, proved: boxes are pruned, halved, and closed by Krawczyk's operator, many at once.

A box holds no equilibrium if a derivative, over the whole box by interval arithmetic, does not contain zero, or if
what Newton's method can reach from anywhere in it (the interval form of one Gauss-Seidel step, with and without a
preconditioner) lies outside. It holds exactly one if Krawczyk's operator maps it, made a little wider, into its own
interior. What is neither is cut in half. Halves are equal in asinh(u), so large boxes cost a cut per factor of two.

Where the equations compare values, derivatives of second order mean nothing on a box in which a comparison is not
certain: such boxes are only pruned by the first test and cut.

References
----------
.. [1] A. Neumaier, Interval Methods for Systems of Equations (1990), chapter 5.
.. [2] R. Krawczyk, Computing 4, 187 (1969).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from quavsweep.analysis.equilibrium import solve, vector_field
from quavsweep.analysis.interval import OPERATIONS, Interval, below
from quavsweep.kernels.program import Program

WIDER = 0.1  # of its width on each side, by which a box is made wider before it is closed
FINEST = 1e-7  # width of a box against 1 + |u| below which it is given up
AT_ONCE = 20_000  # boxes in one evaluation, for memory
LEAST = 1e-10  # of 1 + |u|, by which a box without width is made wider
NEWTON_STEPS = 12  # from the centre of a closed box
GAUSS_SEIDEL = 2  # passes without a preconditioner per cut


def _hull(left: Any, right: Any, first: Any, second: Any) -> Interval:
    """Return `first` or `second` where the comparison is certain, and the hull of both where it is not."""
    (yes, no), first, second = below(left, right), Interval.of(first), Interval.of(second)
    low, high = np.minimum(first.low, second.low), np.maximum(first.high, second.high)
    return Interval(
        np.where(yes, first.low, np.where(no, second.low, low)),
        np.where(yes, first.high, np.where(no, second.high, high)),
    )


VALUES: dict[str, Callable[..., Any]] = {**OPERATIONS, "select_less": _hull, "select_less_equal": _hull}


@dataclass(frozen=True)
class Zeros:
    """Equilibria of m systems, and where it is not known whether there are more.

    Parameters
    ----------
    system : (n,) int
        Which system each equilibrium is of.
    states : (n, D) float64
        Each is the only equilibrium in a box around it.
    open_system : (k,) int
    open_states : (k, D) float64
        Centres of boxes that were neither pruned nor closed.
    """

    system: np.ndarray
    states: np.ndarray
    open_system: np.ndarray
    open_states: np.ndarray


@dataclass
class _Boxes:
    """Boxes (n, D) of systems (n,)."""

    system: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def __len__(self) -> int:
        return len(self.system)

    def __getitem__(self, rows: Any) -> _Boxes:
        return _Boxes(self.system[rows], self.low[rows], self.high[rows])

    @classmethod
    def together(cls, parts: list[_Boxes]) -> _Boxes:
        """Return all boxes of some lists."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("system", "low", "high")))

    def wider(self) -> _Boxes:
        """Return boxes made wider, so that an equilibrium on a border is inside."""
        extra = WIDER * (self.high - self.low) + LEAST * (1.0 + np.abs(self.low))
        return _Boxes(self.system, self.low - extra, self.high + extra)

    def halves(self) -> _Boxes:
        """Return the halves of all boxes, cut across the side that is longest in asinh(u)."""
        rows = np.arange(len(self))
        low, high = np.arcsinh(self.low), np.arcsinh(self.high)
        side = np.argmax(high - low, axis=1)
        cut = np.sinh(0.5 * (low[rows, side] + high[rows, side]))
        left, right = self.high.copy(), self.low.copy()
        left[rows, side], right[rows, side] = cut, cut
        return _Boxes(
            np.concatenate([self.system, self.system]),
            np.concatenate([self.low, right]),
            np.concatenate([left, self.high]),
        )


def enclose_equilibria(
    program: Program, coefficients: np.ndarray, low: np.ndarray, high: np.ndarray, budget: int
) -> Zeros:
    """Return all equilibria of m autonomous systems in a box, as far as a number of boxes suffices to find them.

    Parameters
    ----------
    coefficients : (C, m) float64
    low, high : (D,) float64
        The box [units of the states].
    budget : int
        Boxes looked at for each system; what is left then is open.
    """
    count, dimension = coefficients.shape[1], program.dimension
    todo = _Boxes(np.arange(count), np.tile(low, (count, 1)), np.tile(high, (count, 1)))
    looked, closed, given_up = 0, [], []
    while len(todo):
        now, todo = todo[:AT_ONCE], todo[AT_ONCE:]
        looked += len(now)
        if looked > budget * count:
            given_up.append(_Boxes.together([now, todo]))
            break
        now, unique = _narrowed(program, coefficients, now)
        closed.append(now[unique])
        now = now[~unique]
        tiny = ((now.high - now.low) <= FINEST * (1.0 + np.abs(now.low))).all(axis=1)
        given_up.append(now[tiny])
        todo = _Boxes.together([now[~tiny].halves(), todo])
    nothing = _Boxes(np.empty(0, dtype=int), np.empty((0, dimension)), np.empty((0, dimension)))
    found, left = _Boxes.together([nothing, *closed]), _Boxes.together([nothing, *given_up])
    system, states = _each_once(program, coefficients, found)
    return Zeros(system, states, left.system, 0.5 * (left.low + left.high))


def _narrowed(program: Program, coefficients: np.ndarray, boxes: _Boxes) -> tuple[_Boxes, np.ndarray]:
    """Return the boxes that may hold an equilibrium, narrowed, and which of them hold exactly one, as such a box."""
    with np.errstate(all="ignore"):
        boxes = boxes[_may_vanish(program, coefficients, boxes)]
        for _ in range(GAUSS_SEIDEL):
            boxes = boxes[_gauss_seidel(program, coefficients, boxes)]
        wide = boxes.wider()
        low, high = _krawczyk(program, coefficients, wide)
        unique = np.asarray(((low > wide.low) & (high < wide.high)).all(axis=1))
        low, high = np.maximum(low, boxes.low), np.minimum(high, boxes.high)
        empty = np.asarray((low > high).any(axis=1)) & ~unique
        low, high = np.where(unique[:, None], wide.low, low), np.where(unique[:, None], wide.high, high)
        return _Boxes(boxes.system, low, high)[~empty], unique[~empty]


def _enclosure(boxes: _Boxes) -> list[Interval]:
    return [Interval(boxes.low[:, i], boxes.high[:, i]) for i in range(boxes.low.shape[1])]


def _everywhere(value: Any, n: int) -> Interval:
    """Return an interval per box; what is no number may be any."""
    value = Interval.of(value)
    low, high = np.broadcast_to(value.low, (n,)), np.broadcast_to(value.high, (n,))
    return Interval(np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high))


def _may_vanish(program: Program, coefficients: np.ndarray, boxes: _Boxes) -> np.ndarray:
    """Return whether all derivatives may be zero in each box."""
    names = program.names(_enclosure(boxes), list(coefficients[:, boxes.system]))
    values = [_everywhere(value, len(boxes)) for value in program.evaluate(program.rhs, names, VALUES)]
    return np.asarray(np.logical_and.reduce([(value.low <= 0) & (value.high >= 0) for value in values]))


def _expansion(
    program: Program, coefficients: np.ndarray, boxes: _Boxes
) -> tuple[np.ndarray, list[Interval], list[list[Interval]]]:
    """Return the centres, the derivatives there, and the Jacobian matrices over the boxes."""
    n, c = len(boxes), list(coefficients[:, boxes.system])
    centre = 0.5 * (boxes.low + boxes.high)
    at_centre = program.evaluate(program.rhs, program.names([Interval.of(x) for x in centre.T], c), VALUES)
    entries = [entry for row in program.jacobian for entry in row]
    values = iter(program.evaluate(entries, program.names(_enclosure(boxes), c), OPERATIONS))
    jacobian = [[_everywhere(next(values), n) for _ in program.states] for _ in program.states]
    sure = np.ones(n, dtype=bool)
    compared = iter(
        program.evaluate(
            [side for pair in program.switches for side in pair], program.names(_enclosure(boxes), c), OPERATIONS
        )
    )
    for left, right in zip(compared, compared, strict=True):
        sure &= np.logical_or(*below(left, right))
    for row in jacobian:
        for entry in row:
            entry.low, entry.high = np.where(sure, entry.low, -np.inf), np.where(sure, entry.high, np.inf)
    return centre, [_everywhere(value, n) for value in at_centre], jacobian


def _gauss_seidel(program: Program, coefficients: np.ndarray, boxes: _Boxes) -> np.ndarray:
    """Solve each equation for each state over each box; narrows `boxes` and returns which may hold an equilibrium."""
    centre, value, jacobian = _expansion(program, coefficients, boxes)
    possible = np.ones(len(boxes), dtype=bool)
    size = range(program.dimension)
    for i in size:
        for j in size:
            if not ((jacobian[i][j].low > 0) | (jacobian[i][j].high < 0)).any():
                continue
            rest = value[i]
            for k in size:
                if k != j:
                    away = Interval(boxes.low[:, k], boxes.high[:, k]) - centre[:, k]
                    rest = rest + _product(jacobian[i][k], away)
            reach = _everywhere(centre[:, j] - rest / jacobian[i][j], len(boxes))
            boxes.low[:, j] = np.maximum(boxes.low[:, j], reach.low)
            boxes.high[:, j] = np.minimum(boxes.high[:, j], reach.high)
            possible &= boxes.low[:, j] <= boxes.high[:, j]
    return possible


def _product(a: Interval, b: Interval) -> Interval:
    """Return a product in which zero times infinity is zero: the infinite end is a bound, not a value."""
    corners = [np.where((x == 0) | (y == 0), 0.0, x * y) for x in (a.low, a.high) for y in (b.low, b.high)]
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    return Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))


def _krawczyk(program: Program, coefficients: np.ndarray, boxes: _Boxes) -> tuple[np.ndarray, np.ndarray]:
    """Return the image of each box under Krawczyk's operator, which holds all equilibria of the box, (n, D) twice."""
    n, size = len(boxes), range(program.dimension)
    centre, value, jacobian = _expansion(program, coefficients, boxes)
    inverse = _inverse(np.array([[entry.centre for entry in row] for row in jacobian]))
    away = [Interval(boxes.low[:, j], boxes.high[:, j]) - centre[:, j] for j in size]
    low, high = np.empty((2, n, program.dimension))
    for i in size:
        image = Interval.of(centre[:, i])
        for k in size:
            image = image - value[k] * inverse[i, k]
        for j in size:
            left = Interval.of(np.full(n, 1.0 if i == j else 0.0))
            for k in size:
                left = left - _product(jacobian[k][j], Interval.of(inverse[i, k]))
            image = image + _product(left, away[j])
        image = _everywhere(image, n)
        low[:, i], high[:, i] = image.low, image.high
    return low, high


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverse of n matrices (D, D, n); what is no number where there is none."""
    one = np.broadcast_to(np.eye(len(matrix))[:, :, None], matrix.shape)
    columns = [solve(np.concatenate([matrix, one[:, k : k + 1]], axis=1)) for k in range(len(matrix))]
    return np.stack(columns, axis=1)


def _each_once(program: Program, coefficients: np.ndarray, boxes: _Boxes) -> tuple[np.ndarray, np.ndarray]:
    """Return the equilibria of boxes that hold exactly one; two boxes may hold the same."""
    u = 0.5 * (boxes.low + boxes.high)
    c = coefficients[:, boxes.system]
    for _ in range(NEWTON_STEPS if len(boxes) else 0):
        du, jacobian = vector_field(program, u, c)
        step = solve(np.concatenate([jacobian.transpose(1, 2, 0), du.T[:, None]], axis=1)).T
        u = np.clip(u - step, boxes.low, boxes.high)
    kept: list[int] = []
    for k in range(len(boxes)):
        same = boxes.system[kept] == boxes.system[k]
        inside = ((boxes.low[kept] <= u[k]) & (u[k] <= boxes.high[kept])).all(axis=1)
        if not (same & inside).any():
            kept.append(k)
    kept.sort(key=lambda k: (boxes.system[k], *u[k]))
    return boxes.system[kept], u[kept]
