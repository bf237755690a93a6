"""Figure 11: the attractors of Cases 1, 2 and 3."""

from __future__ import annotations

from typing import TYPE_CHECKING

from quavsweep.codes import REGION
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.flight import make_spaces_figure
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME = "figure_11"
BEHIND = 1000.0  # s


def analyse(runs: Runs) -> Findings:
    """Name what each case does: chaos as long as it lasts, else the region."""
    computed = {f"case{i + 1}": _behaviour(runs[NAME], i) for i in range(3)}
    return Findings(computed)


def _behaviour(seen: Result, case: int) -> Computed:
    """Return what a case does, with how long chaos lasts and what comes then."""
    region, end = REGION[int(seen["region"][case])].meaning, seen.sweep.clock.steps * seen.sweep.clock.dt
    if not seen["was_chaotic"][case]:
        return Computed(region, note=f"L1 = {seen['lyapunov'][case, 0] + 0.0:.4g} 1/s")
    rate, error, until = (seen[n][case] for n in ("lyapunov_chaotic", "lyapunov_chaotic_se", "chaotic_until"))
    while_chaotic = f"L1 = {rate:.3f} +- {error:.3f} 1/s"
    then = f", then {region}; when it ends hangs on the step and on rounding" * bool(until < end)
    return Computed("chaos", note=f"{while_chaotic} until {until:,.0f} s{then}")


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw the three orbits."""
    texts = [f"Case {i + 1}: {findings.computed[f'case{i + 1}'].value}" for i in range(3)]
    return make_spaces_figure(runs[NAME], texts, BEHIND)


FIGURE = Item(NAME, "Orbits of Cases 1, 2 and 3 and what they come to, within 4,000 s", analyse, draw, (NAME,))
