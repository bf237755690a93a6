"""How far exponents moved from one result to another: largest and median changes, and the cells that moved farthest."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

FARTHEST = 5  # cells that are told one by one
_SHIFT = 44  # bits of a number below the eight leading ones of its mantissa


@dataclass
class Sizes:
    """Numbers that are not negative, block by block: how many, the largest, and the median to 0.2 %.

    They are counted in bins by their leading bits, so that the memory does not grow with their number.
    """

    count: int = 0
    _largest: float = 0.0
    _bins: np.ndarray = field(default_factory=lambda: np.zeros(2 ** (63 - _SHIFT), dtype=np.int64))

    def add(self, sizes: np.ndarray) -> None:
        """Take some numbers in, (n,) float64, none of them NaN."""
        self.count += len(sizes)
        self._largest = max(self._largest, float(sizes.max(initial=0.0)))
        bins, counts = np.unique((sizes + 0.0).view(np.uint64) >> np.uint64(_SHIFT), return_counts=True)
        self._bins[bins.astype(np.int64)] += counts

    @property
    def largest(self) -> float:
        """The largest; NaN without any."""
        return self._largest if self.count else np.nan

    @property
    def median(self) -> float:
        """The median, the lower one of an even number; NaN without any."""
        if not self.count:
            return np.nan
        middle = int(np.searchsorted(self._bins.cumsum(), (self.count + 1) // 2))
        if not middle:
            return 0.0
        centre = np.array([(middle << _SHIFT) + (1 << (_SHIFT - 1))], dtype=np.uint64).view(np.float64)[0]
        return min(float(centre), self._largest) if np.isfinite(centre) else np.inf


@dataclass(frozen=True)
class Move:
    """How far an exponent moved among the cells whose region is the same.

    Parameters
    ----------
    exponent : int
        From 1.
    cells : int
        That have a number in both.
    missing : int
        That have one in only one of them.
    largest, median : float
        Of the size of the change [1/time]; the median to 0.2 %.
    with_error : int
        Cells with a standard error; the others are exact in both, or have too few batches.
    largest_in_errors, median_in_errors : float
        Of the size of their change, over the root of the sum of both squared standard errors; NaN without any.
    exact : int
        Cells whose exponent is exact in both.
    largest_exact : float
        Size of the largest change of these [1/time].
    """

    exponent: int
    cells: int
    missing: int
    largest: float
    median: float
    with_error: int
    largest_in_errors: float
    median_in_errors: float
    exact: int
    largest_exact: float


@dataclass(frozen=True)
class Moved:
    """A cell, the exponent that moved farthest in it, and by how much [1/time] and in standard errors.

    Parameters
    ----------
    values : dict
        What varies, by name.
    region : str
    exponent : int
        From 1.
    change : float
        In the second result less that in the first.
    in_errors : float
        Its size in standard errors; NaN if it has none.
    """

    values: dict[str, float]
    region: str
    exponent: int
    change: float
    in_errors: float


class Mover:
    """Gathers how far one exponent moved."""

    def __init__(self) -> None:
        self.sizes, self.errors, self.exact = Sizes(), Sizes(), Sizes()
        self.missing = 0

    def add(self, change: np.ndarray, error: np.ndarray, missing: np.ndarray) -> None:
        """Take in some cells: change, its standard error, and whether only one of both has a number, (n,) each."""
        self.missing += int(missing.sum())
        known = np.isfinite(change)
        size, error = np.abs(change[known]), error[known]
        self.sizes.add(size)
        measured = (error > 0) & np.isfinite(error)
        self.errors.add(size[measured] / error[measured])
        self.exact.add(size[error == 0])

    def told(self, exponent: int) -> Move:
        """Return what was gathered."""
        sizes, errors, exact = self.sizes, self.errors, self.exact
        return Move(
            exponent,
            sizes.count,
            self.missing,
            sizes.largest,
            sizes.median,
            errors.count,
            errors.largest,
            errors.median,
            exact.count,
            exact.largest,
        )


def changes(
    before: np.ndarray, after: np.ndarray, before_se: np.ndarray, after_se: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return changes of exponents, their standard errors, and whether only one has a number, (n, K) each."""
    with np.errstate(invalid="ignore"):
        change = after - before
        error = np.hypot(before_se, after_se)
    return change, error, np.isnan(before) != np.isnan(after)
