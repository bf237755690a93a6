"""What a margin is: probes, the two sides of a direction, gains, and all of it together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from quavsweep.config import Sweep
from quavsweep.margin.criterion import Answer
from quavsweep.margin.direction import Direction, Way

PERCENT = 0.01  # the change of a parameter whose gain is asked for
ROUGH = 0.5  # of the larger one-sided gain; the other must come as near, or a gain is called rough


@dataclass(frozen=True)
class Probe:
    """One point that was run.

    Parameters
    ----------
    values : mapping
        The parameters that any probe varies, by name, in their units.
    answer : Answer
    run : int
        The number of the folder of its run, from 1.
    result_id : str
        Of that run.
    """

    values: Mapping[str, float]
    answer: Answer
    run: int
    result_id: str


@dataclass(frozen=True)
class Side:
    """What was found one way along a direction.

    Parameters
    ----------
    way : Way
    distance : float, optional
        d, see `Found`, a size in the direction's unit; None beyond the limit.
    inner, outer : Probe, optional
        The runs at 0.99 d and 1.01 d; if d is a bound, at the base point and at d.
    scan : tuple of (float, Probe)
        The points of the scan that were run, by distance.
    bound : bool
        Whether d is only a bound: the answer changes too near to the base point for 0.99 d and 1.01 d to be run.
    """

    way: Way
    distance: float | None
    inner: Probe | None
    outer: Probe | None
    scan: tuple[tuple[float, Probe], ...]
    bound: bool = False

    @property
    def change(self) -> float | None:
        """The change of the parameter to that point: d with the sign of its direction, no matter what lies there."""
        return None if self.distance is None else self.way.sign * self.distance


@dataclass(frozen=True)
class Line:
    """A direction both ways."""

    direction: Direction
    base: Probe
    sides: tuple[Side, ...]

    @property
    def nearest(self) -> Side | None:
        """The side on which the nearest change lies; None if there is none within reach."""
        changes = [side for side in self.sides if side.distance is not None]
        return min(changes, key=lambda side: side.distance or 0.0, default=None)

    @property
    def to(self) -> str:
        """What the distance is to, `tumbling` or, where the craft tumbles at the base point of the line, `safety`."""
        return "safety" if self.base.answer.tumbles else "tumbling"

    @property
    def distance(self) -> float | None:
        """The distance to the nearest change, a size; `to` says what it is to, `nearest.change` which way it lies."""
        return None if self.nearest is None else self.nearest.distance

    @property
    def margin(self) -> float | None:
        """The distance if it is one to tumbling, less the distance if it is one to safety: the more, the better."""
        return None if self.distance is None else self.distance * (-1 if self.base.answer.tumbles else 1)

    @property
    def bound(self) -> bool:
        """Whether the distance is only a bound."""
        return self.nearest is not None and self.nearest.bound

    @property
    def span(self) -> tuple[float, float]:
        """The parameter's values from which and up to which both sides were looked at."""
        ends = [self.direction.base + side.way.sign * side.way.limit for side in self.sides]
        return min(ends), max(ends)


@dataclass(frozen=True)
class Gain:
    """What a change of one parameter does to the margin along the leading direction: above 0 it is safer.

    Parameters
    ----------
    name : str
    enters : bool
        Whether the model has such a parameter; if not, the gain is 0.
    below, above : Line, optional
        The leading direction of the craft with 1 % less and 1 % more of it; None where no such craft is possible.
    base : Line, optional
        That of the craft itself. Where a line has no change within reach, it is one that goes farther.
    """

    name: str
    enters: bool
    below: Line | None = None
    above: Line | None = None
    base: Line | None = None

    @property
    def from_below(self) -> float:
        """The margin less that at -1 %; NaN where one of them is not known, or only a bound."""
        return _less(self.base, self.below) if self.enters else 0.0

    @property
    def from_above(self) -> float:
        """The margin at +1 % less that of the craft itself."""
        return _less(self.above, self.base) if self.enters else 0.0

    @property
    def per_percent(self) -> float:
        """Half the difference of the margins at +1 % and -1 %."""
        return 0.5 * _less(self.above, self.below) if self.enters else 0.0

    @property
    def rough(self) -> bool:
        """Whether both one-sided gains are known and do not agree."""
        sides = self.from_below, self.from_above
        return abs(sides[0] - sides[1]) > ROUGH * max(map(abs, sides))

    @property
    def bound(self) -> bool:
        """Whether a distance that it needs is only a bound."""
        return any(line is not None and line.bound for line in (self.base, self.below, self.above))

    @property
    def lacking(self) -> Line | None:
        """The first line without a change that the gain needs; None if there is none such."""
        lines = [line for line in (self.below, self.above) if line is not None]
        return next((line for line in lines if line.margin is None), None)


def _less(one: Line | None, other: Line | None) -> float:
    """Return the difference of two margins, NaN unless both are known."""
    if one is None or other is None or one.margin is None or other.margin is None or one.bound or other.bound:
        return math.nan
    return one.margin - other.margin


@dataclass(frozen=True)
class Margin:
    """How far a craft is from tumbling.

    Parameters
    ----------
    sweep : Sweep
        Whose craft, start and integration these are.
    by : str
        `region`, `basin` or `angle`.
    criterion : str
        What tumbling means, in words.
    craft, initial : mapping
        Parameters and the initial state that were used.
    notes : tuple of str
        What of the config was not used, and what instead.
    reach : float
        How far the directions were scanned, as a share of the base value.
    lines : tuple of Line
        The directions.
    absent : tuple of str
        Directions of a craft that do not enter the model.
    gains : tuple of Gain
    runs : tuple of (str, int)
        Result id and number of points of each run, in order.
    folder : Path
        Where the runs lie.
    """

    sweep: Sweep
    by: str
    criterion: str
    craft: Mapping[str, float]
    initial: Mapping[str, float]
    notes: tuple[str, ...]
    reach: float
    lines: tuple[Line, ...]
    absent: tuple[str, ...]
    gains: tuple[Gain, ...]
    runs: tuple[tuple[str, int], ...]
    folder: Path = field(compare=False)

    @property
    def base(self) -> Probe:
        """The craft itself."""
        return self.lines[0].base

    @property
    def leading(self) -> Line:
        """The direction whose distance the gains are of."""
        return self.lines[0]

    @property
    def leading_for_gains(self) -> Line | None:
        """The leading direction of the craft itself as gains know it, maybe followed farther than the reach."""
        return next((gain.base for gain in self.gains), None)

    def unit(self, line: Line) -> str:
        """Return the unit of a direction."""
        return self.sweep.model.quantity(line.direction.along).unit
