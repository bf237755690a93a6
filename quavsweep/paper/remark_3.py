"""Remark 3 held against the exponents: what the Casimir power tells of orbits over the plane of Figure 5."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.quadrotor.remark_3 import CASE, REGION_OF_CASE, TOLERANCE, Case, classify_power
from quavsweep.codes import REGION, Region
from quavsweep.paper.interval import HORIZON
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.observed import observed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.agreement import AGREEMENT, Told, make_agreement_figure
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLOW = "remark_3_slow"
SLAB = 16  # values of the first axis that are read at once: 40 MB
TOLERANCES = (0.03, TOLERANCE, 0.003, 0.001)
SOURCE = "source"  # the paper's word for what diverges


@dataclass(frozen=True)
class Comparison:
    """What power and exponents tell of each cell of the coarser plane, (n, m) int8 each."""

    case: np.ndarray
    region: np.ndarray

    @property
    def decided(self) -> np.ndarray:
        """Whether the exponents decide, (n, m) bool."""
        return np.asarray(self.region != Region.UNDECIDED)

    @property
    def agree(self) -> np.ndarray:
        """Whether both tell the same, (n, m) bool."""
        return np.asarray(REGION_OF_CASE[self.case] == self.region)


def analyse(runs: Runs) -> Findings:
    """Classify each cell by its power, and compare with the regions of Figure 5 at the same horizon."""
    coarse, fine = runs["remark_3"], runs.result("figure_05", HORIZON)
    region = fine["region"][same_cells(coarse, fine)]
    cases = cases_of(coarse, TOLERANCES)
    both = Comparison(cases[TOLERANCES.index(TOLERANCE)], region)
    computed = {f"case.{int(case)}": Computed(_majority(both, case)) for case in Case if case}
    computed |= signed_cases(runs[SLOW])
    tables = (_confusion(both), _tolerances(cases, region))
    return Findings(computed, data=both, tables=tables, text=_text(both, float(np.ptp(coarse["time"]))))


def signed_cases(result: Result) -> dict[str, Computed]:
    """Return where orbits end whose power has one sign at all recorded times, by the cases that speak of them."""
    power = observed(result, ("casimir_power",))[..., 0]
    told = {}
    for case, sign in ((Case.POSITIVE, 1), (Case.NEGATIVE, -1)):
        cells = np.flatnonzero((sign * power > 0).all(axis=-1))
        start = ", ".join(f"{result['r'][k]:g}" for k in cells)
        note = f"at Omega1 = {result.sweep.parameters['Omega1']:g} rad/s from r = {start} rad/s"
        ends = {REGION[int(result["region"][k])].meaning for k in cells}
        told[f"case.{int(case)}"] = Computed(" or ".join(sorted(ends)) or "no orbit", note=note if ends else "")
    return told


def same_cells(coarse: Result, fine: Result) -> tuple[np.ndarray, ...]:
    """Return where the cells of a sweep are in a finer one over the same plane, as an index of its arrays.

    Raises
    ------
    ValueError
        If some of them are not in it.
    """
    index = []
    for own, other in zip(coarse.sweep.grid.axes, fine.sweep.grid.axes, strict=True):
        apart = np.abs(np.asarray(own.values)[:, None] - np.asarray(other.values))
        if own.name != other.name or apart.min(axis=1).max() > 1e-9 * np.ptp(own.values):
            raise ValueError(f"{own.name}: the values of one sweep are not among those of the other")
        index.append(apart.argmin(axis=1))
    return np.ix_(*index)


def cases_of(result: Result, tolerances: tuple[float, ...]) -> list[np.ndarray]:
    """Return the case of each cell by the power along its recorded orbit, for some tolerances, (n, m) int8 each."""
    n, dt = len(result["Omega1"]), float(result["time"][1] - result["time"][0])
    found: list[list[np.ndarray]] = [[] for _ in tolerances]
    for first in range(0, n, SLAB):
        power = observed(result, ("casimir_power",), slice(first, min(first + SLAB, n)))[..., 0]
        for cases, tolerance in zip(found, tolerances, strict=True):
            case, _ = classify_power(power.reshape(-1, power.shape[-1]), dt, tolerance=tolerance)
            cases.append(case.reshape(power.shape[:-1]))
    return [np.concatenate(cases) for cases in found]


def _majority(both: Comparison, case: Case) -> str:
    """Return what the exponents say of most cells in a case."""
    regions, counts = np.unique(both.region[both.case == case], return_counts=True)
    if not regions.size:
        return "no orbit"
    most = Region(int(regions[counts.argmax()]))
    return SOURCE if most is Region.UNBOUNDED else REGION[most].meaning


def _confusion(both: Comparison) -> Table:
    """Return how many cells are in each case and region."""
    present = [case for case in Case if (both.case == case).any()]
    rows = [
        (code.meaning, *(f"{int(((both.region == code.number) & (both.case == case)).sum()):,}" for case in present))
        for code in REGION
        if (both.region == code.number).any()
    ]
    head = ("by the exponents", *(CASE[int(case)].meaning for case in present))
    return Table(f"Cells by the exponents at {HORIZON:g} s (rows) and by Remark 3 (columns)", head, rows)


def _tolerances(cases: list[np.ndarray], region: np.ndarray) -> Table:
    """Return the agreement for other tolerances, so that none needs to be believed."""
    rows = []
    for tolerance, case in zip(TOLERANCES, cases, strict=True):
        both = Comparison(case, region)
        rows.append((f"{tolerance:g}", f"{both.agree.mean():.2%}", f"{both.agree[both.decided].mean():.2%}"))
    head = ("maxima are the same within, of the range", "agreement", "where the exponents decide")
    return Table("The one threshold that matters", head, rows)


def _text(both: Comparison, stretch: float) -> str:
    """Say how often the two agree."""
    decided = both.decided
    return (
        f"Remark 3, which sees the last {stretch:g} s of Casimir power alone, and the exponents at {HORIZON:g} s agree "
        f"in {both.agree.mean():.2%} of {both.agree.size:,} cells, in {both.agree[decided].mean():.2%} of the "
        f"{int(decided.sum()):,} in which the exponents decide. "
        "Rows of cases (1) and (3) are of orbits below the pitchfork."
    )


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw the two maps, and where they agree."""
    both: Comparison = findings.data
    agree = np.where(both.decided, both.agree, AGREEMENT[-1].number)
    maps = (
        Told(f"(a) by the exponents, at {HORIZON:g} s", REGION, both.region),
        Told("(b) by Remark 3", CASE, both.case),
        Told("(c) where the two agree", AGREEMENT, agree),
    )
    return make_agreement_figure(runs["remark_3"], maps)


FIGURE = Item(
    name="remark_3",
    title="What orbits do, by their exponents and by Remark 3 from their Casimir power, and where the two agree",
    configs=("remark_3", "figure_05", SLOW),
    analyse=analyse,
    draw=draw,
)
