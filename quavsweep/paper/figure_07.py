"""Figure 7: orbit diagrams of roll rate and Casimir power over the rotor speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.stretch import best_border, stretches
from quavsweep.codes import REGION, Region
from quavsweep.paper.diagram import draw_diagram, sink_power
from quavsweep.paper.interval import HORIZON, Interval, Line, border, chaotic_stretches, line_of, shares
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "figure_07"
KINDS = (Region.SINK, Region.CHAOS, Region.PERIODIC, Region.CHAOS, Region.PERIODIC)
ENDS = ("start", "sink.end", "chaos.end", "periodic.end", "chaos.end.2", "end")
SINKS = "sink.30", "sink.100"
ZERO = 1e-12  # of the supplied power, that rounding leaves


def analyse(runs: Runs) -> Findings:
    """Compare the intervals of the paper with the regions, and the sinks with their names."""
    printed = {row.key: float(row.number or 0) for row in read_printed(NAME)}
    intervals = [Interval(printed[a], printed[b], k) for a, b, k in zip(ENDS, ENDS[1:], KINDS, strict=False)]
    line, seen = line_of(runs, NAME, "Omega1"), runs.result(NAME, HORIZON)
    computed = {
        end: border(line, before, after) for end, before, after in zip(ENDS[1:], intervals, intervals[1:], strict=False)
    }
    computed |= {
        "start": Computed(_first(line, intervals[0]), line.step, "the first column that is a sink", given=True),
        "end": Computed(_last(line, intervals[-1]), line.step, "the last column that is periodic", given=True),
        "change": Computed(_change(seen, intervals[0]), line.step, "best border between the two sinks"),
        "power": Computed("zero" if sink_power(seen, "equilibrium") < ZERO else "not zero", note=_power(seen)),
    }
    computed |= {key: Computed(_sink(seen, float(key.partition(".")[2]))) for key in SINKS}
    found = computed["sink.end"]
    computed["sink.end"] = Computed(found.value, found.error, f"{found.note}; {_second(seen)}")
    tables = (
        shares(line, intervals, "The paper's intervals of Omega1 [rad/s]"),
        chaotic_stretches(line, "Chaotic stretches of Omega1", "rad/s"),
    )
    return Findings(computed, data=line.strips(intervals), tables=tables, text=_text(line))


def _power(seen: Result) -> str:
    """Return how large the power is at the equilibria, and where integration ended near them, in words."""
    left = sink_power(seen, "final_state")
    return f"at the equilibria, to round-off; where integration ended near them {left:.0%} of the supply at most"


def _first(line: Line, interval: Interval) -> float:
    """Return the first position that has the region of an interval."""
    return float(line.positions[np.argmax(line.seen == interval.region)])


def _last(line: Line, interval: Interval) -> float:
    """Return the last position that has the region of an interval."""
    return float(line.positions[::-1][np.argmax(line.seen[::-1] == interval.region)])


def _change(seen: Result, sinks: Interval) -> float:
    """Return the speed up to which orbits come to the sink with p > 0, within the paper's interval of sinks."""
    speed, p = seen["Omega1"], seen["equilibrium"][:, 0]
    inside = (seen["region"] == Region.SINK) & (speed <= sinks.high) & (p != 0)
    k = best_border(p[inside] > 0, p[inside] < 0)
    own = speed[inside]
    return float(own[max(k - 1, 0) : k + 1].mean())


def _second(seen: Result) -> str:
    """Return over which speeds the orbit comes to the sink with p < 0 without exception, in words."""
    second = (seen["region"] == Region.SINK) & (seen["equilibrium"][:, 0] < 0)
    runs = [seen["Omega1"][[a, b]] for a, b in stretches(second, gap=0)]
    low, high = max(runs, key=np.ptp) if runs else (np.nan, np.nan)
    return f"every orbit from {low:g} to {high:g} rad/s comes to E3"


def _sink(seen: Result, speed: float) -> str:
    """Return the paper's name of the sink at a speed: E2 with p > 0, E3 with p < 0; or the region if it is none."""
    cell = seen.at(Omega1=speed)
    if cell["region"] != Region.SINK:
        return REGION[int(cell["region"])].meaning
    return "E2" if cell["equilibrium"][0] > 0 else "E3"


def _text(line: Line) -> str:
    """Return how many columns are chaotic at each time."""
    counts = [f"{np.count_nonzero(r == Region.CHAOS)} at {t.split(' ')[0]} s" for t, r in line.regions.items()]
    return f"Of {len(line.positions):,} columns, {' and '.join(counts)} are chaotic."


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw both diagrams, with the paper's intervals on top."""
    return draw_diagram(runs[NAME], runs.result(NAME, HORIZON), findings.data)


FIGURE = Item(
    NAME,
    "Maxima of the roll rate, and the Casimir power there, over the rotor speed; on top the paper's intervals and the "
    "regions at 4,000 s and in the end",
    analyse,
    draw,
    (NAME,),
)
