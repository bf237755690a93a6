"""Interval arithmetic on arrays, with outward rounding: what a bound must hold for, holds."""

from __future__ import annotations

from typing import Any

import numpy as np


class Interval:
    """All values between `low` and `high`, elementwise.

    Every operation rounds outward by one unit in the last place, so the exact result lies inside.
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

    __radd__ = __add__
    __rmul__ = __mul__


def _outward(low: np.ndarray, high: np.ndarray) -> Interval:
    return Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))
