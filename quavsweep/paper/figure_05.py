"""Figure 5: regions over rotor speed and speed difference, at 4,000 s and in the end, beside the lifetimes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from quavsweep.paper.hover import hovering_curve
from quavsweep.paper.interval import HORIZON
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.paper.survival import fate_of_chaos, trend
from quavsweep.plot.twice import make_twice_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "figure_05"


def analyse(runs: Runs) -> Findings:
    """Count what becomes of chaos, and see where it is as c grows."""
    seen = runs.result(NAME, HORIZON)
    table, text = fate_of_chaos(seen, runs[NAME])
    computed = {"trend": Computed(trend(seen), note="mean Omega1 of the chaotic cells, as c grows")}
    return Findings(computed, tables=(table,), text=text)


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw both maps and that of the lifetimes, with the hovering curve."""
    seen, end = runs.result(NAME, HORIZON), runs[NAME]
    return make_twice_figure((seen, end), [hovering_curve(end)], runs["lifetime_map"].points)


FIGURE = Item(
    NAME,
    "Regions over rotor speed and speed difference from (0.001, 0.001, 0.001) rad/s, at 4,000 s and in the end, and "
    "the mean lifetime of chaos from 256 starts",
    analyse,
    draw,
    (NAME, "lifetime_map"),
)
