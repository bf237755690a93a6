"""A number of the paper beside the computed one, and the verdict that follows from the two."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum

ERRORS = 2.0  # of the computed value, within which it agrees


class Verdict(StrEnum):
    """What a comparison says."""

    AGREES = "agrees"
    WITHIN = "agrees within the error"
    DIFFERS = "differs"
    GIVEN = "taken as given"
    MISSING = "not computed"


@dataclass(frozen=True)
class Printed:
    """What the paper says.

    Parameters
    ----------
    key : str
        Names the quantity within its figure or table.
    where : str
        Where the paper says it, as `Section 3` or `Table 3`.
    what : str
        What it is of.
    paper : str
        The number with the digits that are printed, or a word.
    unit : str
    reason : str
        Why the computed value differs, as far as that is shown; it has no part in the verdict, and is told only
        where the two differ.
    """

    key: str
    where: str
    what: str
    paper: str
    unit: str = ""
    reason: str = ""

    @property
    def number(self) -> Decimal | None:
        """The number, None of a word."""
        return Decimal(self.paper) if re.fullmatch(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?", self.paper) else None

    @property
    def half_unit(self) -> float:
        """Half a unit of the last printed digit."""
        number = self.number
        assert number is not None
        exponent = number.as_tuple().exponent
        assert isinstance(exponent, int)
        return 0.5 * 10.0**exponent


@dataclass(frozen=True)
class Computed:
    """What is computed.

    Parameters
    ----------
    value : float or str
        A number in the paper's unit, or a word.
    error : float
        Its standard error, or the step of the grid that it was read from; 0 where it is exact.
    note : str
        How it was found, where that is not plain.
    given : bool
        Whether it is an input of what is computed, so that agreeing says nothing.
    """

    value: float | str
    error: float = 0.0
    note: str = ""
    given: bool = False


@dataclass(frozen=True)
class Row:
    """What the paper prints and what was computed, None where nothing was."""

    printed: Printed
    computed: Computed | None

    @property
    def verdict(self) -> Verdict:
        """The verdict, from the printed digits, the computed value and its error alone."""
        printed, computed = self.printed, self.computed
        if computed is None:
            return Verdict.MISSING
        same = Verdict.GIVEN if computed.given else Verdict.AGREES
        number = printed.number
        if number is None or isinstance(computed.value, str):
            return same if str(computed.value) == printed.paper else Verdict.DIFFERS
        apart = abs(computed.value - float(number))
        allowed = printed.half_unit * (1.0 + 1e-9)
        if apart <= allowed:
            return same
        return Verdict.WITHIN if apart <= allowed + ERRORS * computed.error else Verdict.DIFFERS

    @property
    def reason(self) -> str:
        """What is known of a difference; empty where there is none."""
        return self.printed.reason if self.verdict is Verdict.DIFFERS else ""

    @property
    def shown(self) -> str:
        """The computed value with two digits more than are printed."""
        if self.computed is None or isinstance(self.computed.value, str):
            return "" if self.computed is None else str(self.computed.value)
        value, number = float(self.computed.value), self.printed.number
        if number is None or not math.isfinite(value) or not value:
            return f"{value:.6g}"
        digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(2.0 * self.printed.half_unit)) + 3
        return f"{value:.{min(max(digits, 3), 12)}g}"
