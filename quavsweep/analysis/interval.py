"""Interval arithmetic on arrays, with outward rounding: what a bound must hold for, holds."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from quavsweep.kernels.formula import FUNCTIONS, on_arrays

ULPS = 4  # functions are rounded outward by so many units in the last place; they are within 2 of the truth
TURNING = 2.0**20  # sines of larger numbers are bounded by -1 and 1 alone
UNSURE = 1e-9  # in turns; a peak of a sine that is so near counts as inside


class Interval:
    """All values between `low` and `high`, elementwise.

    Every operation rounds outward by one unit in the last place, functions by four, so the exact result lies inside.
    """

    __array_ufunc__ = None  # so that array * Interval comes here

    def __init__(self, low: Any, high: Any) -> None:
        self.low = np.asarray(low, dtype=np.float64)
        self.high = np.asarray(high, dtype=np.float64)

    @classmethod
    def of(cls, value: Any) -> Interval:
        """Return an interval as it is, and a number or array as intervals of no width."""
        return value if isinstance(value, Interval) else cls(value, value)

    @property
    def centre(self) -> np.ndarray:
        """Midpoints."""
        return 0.5 * (self.low + self.high)

    @property
    def radius(self) -> np.ndarray:
        """Half widths, rounded up; 0 for an interval of no width."""
        centre = self.centre
        wide = np.maximum(self.high - centre, centre - self.low)
        return np.where(self.high == self.low, 0.0, np.nextafter(wide, np.inf))

    def __add__(self, other: Any) -> Interval:
        other = Interval.of(other)
        return _outward(self.low + other.low, self.high + other.high)

    def __sub__(self, other: Any) -> Interval:
        return self + -Interval.of(other)

    def __rsub__(self, other: Any) -> Interval:
        return Interval.of(other) - self

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __mul__(self, other: Any) -> Interval:
        other = Interval.of(other)
        corners = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return _outward(np.minimum.reduce(corners), np.maximum.reduce(corners))

    def __truediv__(self, other: Any) -> Interval:
        other = Interval.of(other)
        crosses = (other.low <= 0) & (other.high >= 0)
        quotient = self * _outward(1.0 / other.high, 1.0 / other.low)
        return Interval(np.where(crosses, -np.inf, quotient.low), np.where(crosses, np.inf, quotient.high))

    def __rtruediv__(self, other: Any) -> Interval:
        return Interval.of(other) / self

    def sqrt(self) -> Interval:
        """Return the square roots; nan where a value may be negative."""
        return _outward(np.sqrt(self.low), np.sqrt(self.high))

    def rising(self, function: Callable[[Any], Any]) -> Interval:
        """Return the values of a function that rises; nan where it is not defined."""
        return _outward(function(self.low), function(self.high), ULPS)

    def cosh(self) -> Interval:
        """Return the hyperbolic cosines, the least at the value nearest to zero."""
        function = on_arrays("cosh")
        ends = function(self.low), function(self.high)
        least = np.where((self.low <= 0) & (self.high >= 0), 1.0, np.minimum(*ends))
        return _outward(least, np.maximum(*ends), ULPS)

    def wave(self, name: str, crest: float) -> Interval:
        """Return sines or cosines, whose largest value 1 is at `crest` [rad] and whole turns from there."""
        function = on_arrays(name)
        ends = function(self.low), function(self.high)
        far = ~(np.maximum(np.abs(self.low), np.abs(self.high)) <= TURNING)
        high = np.where(far | self._meets(crest), 1.0, np.maximum(*ends))
        low = np.where(far | self._meets(crest + np.pi), -1.0, np.minimum(*ends))
        return _outward(low, high, ULPS)

    def _meets(self, angle: float) -> np.ndarray:
        """Return whether an angle, or one that is whole turns from it, may lie inside."""
        first, last = ((end - angle) / (2.0 * np.pi) for end in (self.low, self.high))
        return np.asarray(np.ceil(first - UNSURE) <= np.floor(last + UNSURE))

    __radd__ = __add__
    __rmul__ = __mul__


def below(left: Any, right: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return where all values of the left are surely below all of the right, and where surely above."""
    left, right = Interval.of(left), Interval.of(right)
    return np.asarray(left.high < right.low), np.asarray(left.low > right.high)


def _select(left: Any, right: Any, first: Any, second: Any) -> Interval:
    """Return `first` or `second` where the comparison is certain, and all numbers where it is not."""
    (yes, no), first, second = below(left, right), Interval.of(first), Interval.of(second)
    low, high = ((getattr(first, end), getattr(second, end)) for end in ("low", "high"))
    return Interval(
        np.where(yes, low[0], np.where(no, low[1], -np.inf)), np.where(yes, high[0], np.where(no, high[1], np.inf))
    )


def _outward(low: np.ndarray, high: np.ndarray, ulps: int = 1) -> Interval:
    for _ in range(ulps):
        low, high = np.nextafter(low, -np.inf), np.nextafter(high, np.inf)
    return Interval(low, high)


def _rising(name: str) -> Callable[[Any], Interval]:
    return lambda x: Interval.of(x).rising(on_arrays(name))


def _sin(x: Any) -> Interval:
    return Interval.of(x).wave("sin", 0.5 * np.pi)


def _cos(x: Any) -> Interval:
    return Interval.of(x).wave("cos", 0.0)


# What a program needs to be evaluated on intervals.
OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    **{name: _rising(name) for name in FUNCTIONS},
    "sqrt": lambda x: Interval.of(x).sqrt(),
    "cosh": lambda x: Interval.of(x).cosh(),
    "sin": _sin,
    "cos": _cos,
    "tan": lambda x: _sin(x) / _cos(x),
    "select_less": _select,
    "select_less_equal": _select,
}
