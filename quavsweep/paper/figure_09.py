"""Figure 9: regions over rotor speed and moment of inertia at 4,000 s and in the end, and hovering along the latter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.quadrotor.hovering import hovering_speed
from quavsweep.codes import Region
from quavsweep.config import Sweep
from quavsweep.paper.hover import GRAVITY, LIFT, MASS
from quavsweep.paper.interval import HORIZON, Interval, chaotic_ends, chaotic_stretches, line_of, shares
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.paper.survival import fate_of_chaos, trend
from quavsweep.plot.overlay import Curve
from quavsweep.plot.twice import make_twice_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME, LINE = "figure_09", "hover_ix"
UNIT = "kg m2"
LABEL = "hovering at c = 5 rad/s"
SLIP = 100.0  # between the exponents that are printed and those of a rigid body


def analyse(runs: Runs) -> Findings:
    """Count what becomes of chaos, and compare where hovering is chaotic with what the paper says."""
    printed = {row.key: float(row.number or 0) for row in read_printed(NAME)}
    seen, line = runs.result(NAME, HORIZON), line_of(runs, LINE, "Ix")
    said = Interval(SLIP * printed["chaos.low"], SLIP * printed["chaos.high"], Region.CHAOS)
    note = f"the Ix that tell chaos best at {HORIZON:,.0f} s, over {line.positions[0]:g} to {line.positions[-1]:g}"
    craft = runs[LINE].sweep.parameters
    low, high = chaotic_ends(line, note)
    computed = {
        "trend": Computed(trend(seen), note="mean Omega1 of the chaotic cells, as Ix grows"),
        "rigid": Computed(_rigid(runs[LINE].sweep, printed["range.low"], printed["range.high"])),
        "range.low": Computed(float(seen["Ix"].min()), note="what is computed here", given=True),
        "range.high": Computed(float(seen["Ix"].max()), note="what is computed here", given=True),
        "hover": Computed(float(craft["Omega1"]), note=f"of the craft that hovers at c = {craft['c']:g} rad/s, (22)"),
        "hover.2": Computed(float(hovering_speed(craft["c"], MASS, GRAVITY, LIFT)), note="the same, by (22)"),
        "chaos.low": low,
        "chaos.high": high,
    }
    fate, text = fate_of_chaos(seen, runs[NAME])
    tables = (
        fate,
        shares(
            line, [said], "Hovering where the paper says that it tends to chaos, in Ix [kg m2], exponents corrected"
        ),
        chaotic_stretches(line, "Stretches of Ix on which hovering is chaotic", UNIT),
    )
    return Findings(computed, data=line.strips([said]), tables=tables, text=text)


def _rigid(sweep: Sweep, low: float, high: float) -> str:
    """Return whether a rigid body can have such moments of inertia about x, in a word."""
    parameters = dict(sweep.parameters)
    holds = [
        bool(relation.holds(**{name: {**parameters, "Ix": ix}[name] for name in relation.parameters}))
        for relation in sweep.model.relations
        for ix in (low, high)
    ]
    return "yes" if all(holds) else "no"


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw both maps with the hovering line, and the regions along it."""
    seen, end, line = runs.result(NAME, HORIZON), runs[NAME], runs[LINE]
    speed = line.sweep.parameters["Omega1"]
    ends = np.asarray(end.sweep.grid.axes[1].values)[[0, -1]]
    hovering = Curve(LABEL, (np.column_stack([[speed, speed], ends]),))
    return make_twice_figure((seen, end), [hovering], strips=(line, findings.data, LABEL))


FIGURE = Item(
    NAME,
    "Regions over rotor speed and moment of inertia from (0.001, 0.001, 0.001) rad/s, at 4,000 s and in the end; "
    "below, hovering with c = 5 rad/s",
    analyse,
    draw,
    (NAME, LINE),
)
