"""Directions: the lines through a craft's parameters along which a margin is measured, and how far they go."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from quavsweep.analysis.quadrotor.hovering import hovering_speed
from quavsweep.models import Model, Relation
from quavsweep.models.craft import TABLE_2

CRAFT = ("Omega1", "c", "Ix", "Iy", "Iz", "Ir")  # the directions of a craft
CHANGED = ("Ix", "Iy", "Iz", "Ir", "l")  # the parameters whose change may gain something
HOVERING = "hovering"  # the name of the curve (22)
LIMIT_STEPS = 256  # at which a line's end is looked for
LIMIT_HALVINGS = 40

Values = Mapping[str, float]


@dataclass(frozen=True)
class Direction:
    """A line, or curve, through the parameters of a model.

    Parameters
    ----------
    name : str
        The parameter that varies, or `hovering`.
    along : str
        The parameter that measures it.
    base : float
        Its value at the base point, in its unit.
    others : mapping
        Parameters that differ from the base craft all along it.
    follow : callable, optional
        What else varies: from the value to further parameters by name.
    """

    name: str
    along: str
    base: float
    others: Values = field(default_factory=dict)
    follow: Callable[[float], Values] | None = None

    @property
    def scale(self) -> float:
        """The distance that is called 100 %: the base value's size, or 1 where that is 0."""
        return abs(self.base) or 1.0

    def values(self, distance: float) -> dict[str, float]:
        """Return what differs from the base craft at a signed distance from the base point."""
        value = self.base + distance
        return {**self.others, self.along: value, **(self.follow(value) if self.follow else {})}


def directions_of(model: Model, parameters: Values) -> tuple[Direction, ...]:
    """Return the directions of a craft: those of its six parameters that the model has, and the hovering curve.

    A model that is no craft, which has no parameter `Omega1`, has all its parameters for directions.
    """
    names = [name for name in CRAFT if name in parameters] if is_craft(model) else model.parameter_names
    lines = tuple(Direction(name, name, parameters[name]) for name in names)
    return (*lines, hovering_curve(parameters)) if set(CRAFT) <= set(names) else lines


def is_craft(model: Model) -> bool:
    """Whether a model has a rotor speed, so is one of the quadrotor."""
    return CRAFT[0] in model.parameter_names


def changed_parameters(model: Model) -> tuple[str, ...]:
    """Return the parameters whose change may gain distance: Ix, Iy, Iz, Ir, l of a craft, else all but the first."""
    return CHANGED if is_craft(model) else model.parameter_names[1:]


def hovering_curve(parameters: Values) -> Direction:
    """Return the curve on which thrust is weight, equation (22) of the paper, along c at the craft's c.

    A model without lift, mass or gravity has those of Table 2.
    """
    b, m, g = (parameters.get(name, TABLE_2[name].default) for name in ("b", "m", "g"))

    def speed(c: float) -> Values:
        return {"Omega1": float(hovering_speed(c, m, g, b))}

    return Direction(HOVERING, "c", parameters["c"], follow=speed)


@dataclass(frozen=True)
class Way:
    """A direction one way from its base point.

    Parameters
    ----------
    sign : int
        1 towards larger values, -1 towards smaller ones.
    limit : float
        How far it goes, in the direction's unit.
    ended_by : str
        What ends it before the reach that was asked for, if anything: a domain or a relation.
    scan : tuple of float
        The distances of its scan, ascending; none where it goes nowhere.
    """

    direction: Direction
    sign: int
    limit: float
    ended_by: str
    scan: tuple[float, ...]

    @property
    def spacing(self) -> float:
        """Between two points of the scan, in its first part."""
        return self.scan[0] if self.scan else 0.0

    def point(self, distance: float) -> dict[str, float]:
        """Return what differs from the base craft at a distance."""
        return self.direction.values(self.sign * distance)


@dataclass(frozen=True)
class Domain:
    """The parameters that a model admits: in their domains, and by the relations that hold for the base craft."""

    model: Model
    parameters: Values

    def refusal(self, changed: Values) -> str:
        """Return why a craft that differs in some parameters is not possible, empty if it is."""
        values = {**self.parameters, **changed}
        for parameter in self.model.parameters:
            if parameter.name in changed and not parameter.admits(values[parameter.name]):
                return f"{parameter.name} {parameter.domain or 'is no number'}"
        concerned = (relation for relation in self.model.relations if {*relation.parameters} & {*changed})
        return next((r.text for r in concerned if _holds(r, self.parameters) and not _holds(r, values)), "")

    def way(self, direction: Direction, sign: int, reach: float, points: int) -> Way:
        """Return one way of a direction, with evenly spaced points as far as the model admits.

        Parameters
        ----------
        sign : int
            1 or -1.
        reach : float
            How far at most, as a share of the base value.
        points : int
            Up to there.
        """
        farthest = reach * direction.scale
        limit, ended_by = self._limit(direction, sign, farthest)
        count = math.ceil(limit / farthest * points - 1e-9)
        return Way(direction, sign, limit, ended_by, tuple(limit * i / count for i in range(1, count + 1)))

    def farther(self, way: Way, reach: float, coarser: float) -> Way:
        """Return a way that goes on beyond its limit, up to a reach, with points so many times as far apart."""
        limit, ended_by = self._limit(way.direction, way.sign, reach * way.direction.scale)
        if not way.scan or limit <= way.limit:
            return way
        count = math.ceil((limit - way.limit) / (coarser * way.spacing) - 1e-9)
        beyond = tuple(limit - (limit - way.limit) * (count - i) / count for i in range(1, count + 1))
        return Way(way.direction, way.sign, limit, ended_by, (*way.scan, *beyond))

    def _limit(self, direction: Direction, sign: int, reach: float) -> tuple[float, str]:
        """Return how far a direction goes one way, at most `reach` in its unit, and what ends it before."""
        steps = [reach * i / LIMIT_STEPS for i in range(LIMIT_STEPS + 1)]
        refused = (i for i in range(1, len(steps)) if self.refusal(direction.values(sign * steps[i])))
        first = next(refused, None)
        if first is None:
            return reach, ""
        good, bad = steps[first - 1], steps[first]
        for _ in range(LIMIT_HALVINGS):
            middle = 0.5 * (good + bad)
            good, bad = (good, middle) if self.refusal(direction.values(sign * middle)) else (middle, bad)
        return good, self.refusal(direction.values(sign * bad))


def _holds(relation: Relation, values: Values) -> bool:
    return bool(relation.holds(**{name: values[name] for name in relation.parameters}))
