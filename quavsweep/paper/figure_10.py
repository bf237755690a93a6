"""Figure 10: as Figure 7, with another moment of inertia; the paper's text names no interval of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from quavsweep.paper.diagram import draw_diagram
from quavsweep.paper.interval import HORIZON, chaotic_stretches, line_of
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.run import Runs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "figure_10"


def analyse(runs: Runs) -> Findings:
    """Find the chaotic stretches."""
    line = line_of(runs, NAME, "Omega1")
    return Findings(data=line.regions, tables=(chaotic_stretches(line, "Chaotic stretches of Omega1", "rad/s"),))


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw both diagrams."""
    return draw_diagram(runs[NAME], runs.result(NAME, HORIZON), findings.data)


FIGURE = Item(
    NAME,
    "Maxima of the roll rate, and the Casimir power there, over the rotor speed with Ix = 0.004 kg m2; on top the "
    "regions at 4,000 s and in the end",
    analyse,
    draw,
    (NAME,),
)
