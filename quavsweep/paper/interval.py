"""What the paper says of stretches of a line, beside the regions that are computed along it, at two times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from quavsweep.analysis.stretch import best_border, best_interval, border_range, end_range, stretches
from quavsweep.codes import REGION, Region
from quavsweep.paper.item import Table
from quavsweep.paper.row import ERRORS, Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.strip import Strips
from quavsweep.plot.twice import time_text

HORIZON = 4000.0  # s, to which a reader of the paper follows an orbit


@dataclass(frozen=True)
class Interval:
    """A stretch of a line and the region that the paper says it has."""

    low: float
    high: float
    region: Region


@dataclass(frozen=True)
class Line:
    """Regions along a line at several times.

    Parameters
    ----------
    positions : (n,) float64
        Ascending.
    regions : dict
        By the time in words, (n,) int8.
    """

    positions: np.ndarray
    regions: Mapping[str, np.ndarray]

    @property
    def step(self) -> float:
        """The distance of two neighbours."""
        return float(np.diff(self.positions).mean())

    @property
    def seen(self) -> np.ndarray:
        """The regions at the first of the times."""
        return next(iter(self.regions.values()))

    def inside(self, interval: Interval) -> np.ndarray:
        """Whether positions are in an interval, to a thousandth of a step, (n,) bool."""
        slack = 1e-3 * self.step
        return np.asarray((self.positions >= interval.low - slack) & (self.positions <= interval.high + slack))

    def strips(self, intervals: Sequence[Interval]) -> Strips:
        """Return what the paper says, and what is computed at each time, for a figure."""
        said = np.full(len(self.positions), Region.NONE, dtype=np.int8)
        for interval in intervals:
            said[self.inside(interval)] = interval.region
        return {"paper": said, **self.regions}


def line_of(runs: Runs, config: str, name: str) -> Line:
    """Return the regions along the only axis of a sweep, over a quantity, at the horizon and in the end."""
    seen, end = runs.result(config, HORIZON), runs[config]
    order = np.argsort(end[name])
    return Line(end[name][order], {time_text(result): result["region"][order] for result in (seen, end)})


def border(line: Line, before: Interval, after: Interval) -> Computed:
    """Return where the region of an interval gives way to that of the next, at the horizon.

    It is the border with the fewest columns of both intervals on the wrong side. It may be off, two errors, by as much
    as the farthest border with no more of them than that number and its standard deviation, or a step of the grid.
    """
    both = Interval(before.low, after.high, Region.NONE)
    inside = np.flatnonzero(line.inside(both))
    region = line.seen[inside]
    parts = region == before.region, region == after.region
    k, (low, high) = best_border(*parts), border_range(*parts)
    wrong = np.count_nonzero(~parts[0][:k]) + np.count_nonzero(~parts[1][k:])
    begin = int(inside[0])
    note = f"best border at {HORIZON:,.0f} s; {wrong} of {len(inside)} columns differ"
    return Computed(_between(line, begin + k), line.step * max(k - low, high - k, 1) / ERRORS, note)


def _between(line: Line, k: int) -> float:
    """Return the position between the columns before and behind a border."""
    last, first = max(k - 1, 0), min(k, len(line.positions) - 1)
    return float(0.5 * (line.positions[last] + line.positions[first]))


def chaotic_ends(line: Line, note: str) -> tuple[Computed, Computed]:
    """Return the ends of the interval that tells chaos best, at the horizon; errors as those of `border`."""
    has = line.seen == Region.CHAOS
    found = best_interval(has)
    if found is None:
        return Computed(float("nan"), note=note), Computed(float("nan"), note=note)
    ends = zip(found, end_range(has, found), strict=True)
    low, high = (
        Computed(float(line.positions[k]), line.step * max(k - a, b - k, 1) / ERRORS, note) for k, (a, b) in ends
    )
    return low, high


def shares(line: Line, intervals: Sequence[Interval], title: str) -> Table:
    """Return how many of the columns of each interval have the region that the paper says, and the most common one."""
    rows = []
    for interval in intervals:
        inside = line.inside(interval)
        row = [f"{interval.low:g} to {interval.high:g}", REGION[interval.region].meaning]
        for region in line.regions.values():
            own = region[inside]
            most = Region(int(np.bincount(own, minlength=len(REGION)).argmax())) if own.size else Region.NONE
            share = np.count_nonzero(own == interval.region) / max(own.size, 1)
            row.append(f"{share:.0%} of {own.size}" + (f"; most are {REGION[most].meaning}" * bool(share < 0.5)))
        rows.append(row)
    return Table(title, ("interval", "paper", *(f"computed at {_plain(time)}" for time in line.regions)), rows)


def chaotic_stretches(line: Line, title: str, unit: str) -> Table:
    """Return the stretches that are chaotic at each time; single columns without chaos do not end one."""
    rows = [
        (_plain(time), f"{line.positions[a]:.6g} to {line.positions[b]:.6g} {unit}", f"{_chaos(region[a : b + 1])}")
        for time, region in line.regions.items()
        for a, b in stretches(region == Region.CHAOS)
        if b > a
    ]
    more = f"step {line.step:.3g} {unit}, two columns or more"
    return Table(f"{title} ({more})", ("at", "from, to", "chaotic columns"), rows or [("any time", "none", "")])


def _chaos(region: np.ndarray) -> str:
    return f"{np.count_nonzero(region == Region.CHAOS)} of {region.size}"


def _plain(text: str) -> str:
    return text.replace(r"$\mathrm{s}$", "s")
