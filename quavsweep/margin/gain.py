"""Gains: the margin along the leading direction of crafts that differ by 1 % in one parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from quavsweep.margin.direction import Direction, Domain
from quavsweep.margin.finding import PERCENT, Gain, Line
from quavsweep.margin.line import WAYS, find_lines
from quavsweep.margin.probe import Prober

FARTHER = 4.0  # times the reach, as far as a line without a change is followed for gains
COARSER = 8.0  # times the spacing of the scan, with which
STAGES = (0.125, 0.25, 0.5, 1.0)  # of a scan that ends at the first change


def changed_crafts(
    craft: Mapping[str, float], leading: Direction, names: Sequence[str], domain: Domain
) -> list[Direction]:
    """Return the leading direction of the crafts that are possible with 1 % less or more of one parameter."""
    crafts = [{name: craft[name] * (1 + sign * PERCENT)} for name in names if name in craft for sign in WAYS]
    possible = [others for others in crafts if not domain.refusal(others)]
    return [Direction(leading.name, leading.along, leading.base, others) for others in possible]


def find_gains(
    craft: Mapping[str, float],
    names: Sequence[str],
    lines: Sequence[Line],
    domain: Domain,
    reach: float,
    prober: Prober,
) -> tuple[Gain, ...]:
    """Return the gain of each parameter.

    Parameters
    ----------
    craft : mapping
    names : sequence of str
        The parameters whose change may gain something.
    lines : sequence of Line
        The leading direction of the craft itself, then of those of `changed_crafts`.
    domain : Domain
    reach : float
        How far these lines go, as a share of the base value; those without a change are followed farther, coarsely,
        unless the distance of the craft itself is but a bound.
    prober : Prober
    """
    base, *changed = lines if lines[0].bound else _followed(lines, domain, FARTHER * reach, prober)
    gains = []
    for name in names:
        own = {line.direction.others[name] > craft[name]: line for line in changed if name in line.direction.others}
        gains.append(Gain(name, name in craft, own.get(False), own.get(True), base))
    return tuple(gains)


def _followed(lines: Sequence[Line], domain: Domain, reach: float, prober: Prober) -> list[Line]:
    """Return lines, those without a change followed farther; what is known of them is not run again."""
    short = [number for number, line in enumerate(lines) if line.distance is None]
    ways = [domain.farther(side.way, reach, COARSER) for number in short for side in lines[number].sides]
    found = find_lines(ways, [STAGES] * len(ways), prober)
    farther = dict(zip(short, found, strict=True))
    return [farther.get(number, line) for number, line in enumerate(lines)]
