"""What a margin is: probes, the two sides of a direction, gains, and all of it together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from quavsweep.config import Sweep
from quavsweep.margin.criterion import Answer
from quavsweep.margin.direction import Direction, Way
from quavsweep.margin.search import HALVINGS

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
        d, see `Found`, in the direction's unit; None beyond the limit.
    inner, outer : Probe, optional
        The runs at 0.99 d and 1.01 d; if d is a bound, at the base point and at d.
    scan : tuple of (float, Probe)
        The points of the scan that were run, by distance.
    """

    way: Way
    distance: float | None
    inner: Probe | None
    outer: Probe | None
    scan: tuple[tuple[float, Probe], ...]

    @property
    def bound(self) -> bool:
        """Whether d is only a bound: the answer changes too near to the base point to tell where."""
        return self.distance is not None and self.way.spacing * 0.5**HALVINGS >= self.distance


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
    def distance(self) -> float | None:
        """The distance to the nearest point where the craft tumbles; where it does already, less that to safety."""
        nearest = self.nearest
        if nearest is None or nearest.distance is None:
            return None
        return -nearest.distance if self.base.answer.tumbles else nearest.distance

    @property
    def reached(self) -> float:
        """The distance up to which both sides were looked at."""
        return min(side.way.limit for side in self.sides)


@dataclass(frozen=True)
class Gain:
    """What a change of one parameter does to the distance along the leading direction.

    Parameters
    ----------
    name : str
    enters : bool
        Whether the model has such a parameter; if not, the gain is 0.
    below, above : Line, optional
        The leading direction of the craft with 1 % less and 1 % more of it; None where no such craft is possible.
    base : Line, optional
        That of the craft itself.
    """

    name: str
    enters: bool
    below: Line | None = None
    above: Line | None = None
    base: Line | None = None

    @property
    def from_below(self) -> float:
        """The distance less that at -1 %; NaN where one of them is not known."""
        return _less(self.base, self.below) if self.enters else 0.0

    @property
    def from_above(self) -> float:
        """The distance at +1 % less that of the craft itself."""
        return _less(self.above, self.base) if self.enters else 0.0

    @property
    def per_percent(self) -> float:
        """Half the difference of d at +1 % and -1 %."""
        return 0.5 * _less(self.above, self.below) if self.enters else 0.0

    @property
    def rough(self) -> bool:
        """Whether both one-sided gains are known and do not agree."""
        sides = self.from_below, self.from_above
        return abs(sides[0] - sides[1]) > ROUGH * max(map(abs, sides))


def _less(one: Line | None, other: Line | None) -> float:
    """Return the difference of two distances, NaN unless both are known."""
    if one is None or other is None or one.distance is None or other.distance is None:
        return math.nan
    return one.distance - other.distance


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

    def unit(self, line: Line) -> str:
        """Return the unit of a direction."""
        return self.sweep.model.quantity(line.direction.along).unit
