"""Figure 6: the rotor speeds at which the craft hovers, and where hovering is chaotic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.quadrotor.hovering import hovering_speed, hovering_stretch, thrust
from quavsweep.codes import Region
from quavsweep.paper.hover import GRAVITY, LIFT, MASS
from quavsweep.paper.interval import HORIZON, Interval, chaotic_ends, chaotic_stretches, line_of, shares
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.hovering import make_hovering_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME, PLANE = "hover", "figure_05"
UNIT = "rad/s"


def analyse(runs: Runs) -> Findings:
    """Compare the curve, the thrust over the plane, and the chaotic stretch with what the paper says."""
    printed = {row.key: float(row.number or 0) for row in read_printed("figure_06")}
    line = line_of(runs, NAME, "c")
    said = Interval(printed["chaos.c.low"], printed["chaos.c.high"], Region.CHAOS)
    curve, plane = runs[NAME], runs[PLANE]
    speed = hovering_speed(plane.sweep.model.defaults["c"], MASS, GRAVITY, LIFT)
    ranges = float(plane["c"].min()), float(plane["c"].max())
    fastest = float(plane["Omega1"].max())
    corners = [thrust(Omega1, c, LIFT) for Omega1 in (printed["chaos.Omega1.high"], fastest) for c in ranges]
    low, high = chaotic_ends(line, f"the c that tell chaos best at {HORIZON:,.0f} s")
    slow, fast = (_speed(end) for end in (high, low))
    computed = {
        "weight": Computed(MASS * GRAVITY),
        "speed.5": Computed(float(speed)),
        "factor.front": Computed(float(thrust(1.0, -1.0, LIFT)) / LIFT, note="of Omega1^2: two rotors"),
        "factor.side": Computed(float(thrust(0.0, 1.0, LIFT)) / LIFT, note="of (Omega1 + c)^2: two rotors"),
        "lifts.Omega1": Computed(
            float(hovering_speed(ranges[0], MASS, GRAVITY, LIFT)), note=f"hovering at c = {ranges[0]:g} rad/s"
        ),
        "lifts.to": Computed(fastest, given=True),
        "chaos.Omega1.low": slow,
        "chaos.Omega1.high": fast,
        "thrust.low": Computed(float(min(corners))),
        "thrust.high": Computed(float(max(corners))),
        "chaos.c.low": low,
        "chaos.c.high": high,
    }
    tables = (
        shares(line, [said], "Hovering where the paper says that it tends to chaos, in c [rad/s]"),
        chaotic_stretches(line, "Stretches of the curve that are chaotic, in c", UNIT),
    )
    ends = hovering_speed(np.array([said.high, said.low]), MASS, GRAVITY, LIFT)
    named = printed["chaos.Omega1.low"], printed["chaos.Omega1.high"]
    stretch = hovering_stretch(ranges, named, MASS, GRAVITY, LIFT)
    assert stretch is not None
    text = (
        f"The paper's stretch of c is Omega1 = {ends[0]:.2f} to {ends[1]:.2f} rad/s on the curve; the speeds that it "
        f"names beside it are c = {stretch[0]:.2f} to {stretch[1]:.2f} rad/s, nearly the whole curve, which has Omega1 "
        f"= {curve['Omega1'].min():.2f} to {curve['Omega1'].max():.2f} rad/s. {_told(line.regions)}"
    )
    return Findings(computed, data=line.strips([said]), tables=tables, text=text)


def _speed(c: Computed) -> Computed:
    """Return the rotor speed on the curve at a speed difference."""
    at, off = (float(hovering_speed(x, MASS, GRAVITY, LIFT)) for x in (c.value, float(c.value) + c.error))
    return Computed(at, abs(at - off), f"on the curve at c = {c.value:.4g} rad/s")


def _told(regions: Mapping[str, np.ndarray]) -> str:
    """Return how much of the curve is chaotic at each time."""
    parts = [f"{np.mean(r == Region.CHAOS):.1%} at {t.split(' ')[0]} s" for t, r in regions.items()]
    return f"Of the whole curve, {' and '.join(parts)} are chaotic."


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw curve, regions along it, and its place over Figure 5."""
    return make_hovering_figure(runs[NAME], findings.data, runs.result(PLANE, HORIZON))


FIGURE = Item(
    "figure_06",
    "Hovering: rotor speed over speed difference, regions along the curve at 4,000 s and in the end, and the curve "
    "over Figure 5",
    analyse,
    draw,
    (NAME, PLANE),
)
