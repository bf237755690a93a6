"""Figure 8: four orbits in space and their Casimir power, with Remark 3's cases and what the engine says of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.quadrotor.casimir import energy_imbalance, mean_power, mean_power_bound, sign_changes
from quavsweep.analysis.quadrotor.remark_3 import classify_power
from quavsweep.codes import REGION, Region
from quavsweep.models import Observable
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.observed import observed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.power import Powered, make_power_figure
from quavsweep.plot.style import number, unit_text
from quavsweep.plot.trace import Trace
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAMES = ("casimir_energy", "casimir_power", "supplied_power", "dissipated_power")
STRETCH = 200.0  # s, the last part of each orbit, which Remark 3's cases are told from
APPROACH = 100.0  # s, drawn pale


def analyse(runs: Runs) -> Findings:
    """Say of each orbit where it ends, which case of Remark 3 its power is in, and whether its energy adds up."""
    result = runs["figure_08"]
    values = observed(result, NAMES)
    time = result["time"]
    late = time >= time[-1] - STRETCH
    case, _ = classify_power(values[:, late, 1], float(time[1] - time[0]))
    computed: dict[str, Computed] = {}
    for i, speed in enumerate(result["Omega1"]):
        computed[f"end.{speed:g}"] = end_of(result, i)
        computed[f"case.{speed:g}"] = Computed(f"({case[i]})", note=f"of the last {STRETCH:g} s of {time[-1]:g} s")
    return Findings(computed, data=values[..., 1], tables=(_balance(result, values, late),))


def end_of(result: Result, cell: int) -> Computed:
    """Return what an orbit does: where it ends, or chaos if it was chaotic, with the time at which that ended."""
    region = Region(int(result["region"][cell]))
    if result["was_chaotic"][cell]:
        until = float(result["chaotic_until"][cell])
        then = "" if region is Region.CHAOS else f" until about {until:g} s, then {REGION[region].meaning}"
        return Computed("chaos", note=f"as computed here{then}; when it ends hangs on the step and on rounding")
    if region is Region.SINK:
        return Computed("E2" if result["equilibrium"][cell, 0] > 0 else "E3", note="E2 is the sink with p, q > 0")
    return Computed(REGION[region].meaning)


def _balance(result: Result, values: np.ndarray, late: np.ndarray) -> Table:
    """Return what powers and energies add up to: each orbit's extremes, mean and identities."""
    energy, power, supplied, dissipated = (values[:, late, k] for k in range(4))
    dt = float(result["time"][1] - result["time"][0])
    time = dt * (energy.shape[1] - 1)
    even = values[:, : (values.shape[1] - 1) // 2 * 2 + 1]
    columns = {
        "Omega1 (rad/s)": result["Omega1"],
        "least (W)": power.min(axis=1),
        "largest (W)": power.max(axis=1),
        "mean (W)": mean_power(energy, time),
        "its bound (W)": mean_power_bound(energy, time),
        "changes of sign": sign_changes(power),
        "power less supplied less dissipated, at most (W)": np.abs(power - (supplied - dissipated)).max(axis=1),
        "integral less change of energy, from t = 0 (J)": energy_imbalance(even[..., 0], even[..., 1], dt),
    }
    rows = [[f"{column[i]:.4g}" for column in columns.values()] for i in range(len(power))]
    return Table(f"Casimir power over the last {STRETCH:g} s", list(columns), rows)


def orbits(result: Result, power: np.ndarray, cells: range) -> list[Powered]:
    """Return some orbits with their powers, for a figure."""
    model, speed = result.sweep.model, result.sweep.model.quantity("Omega1")
    found = []
    for i in cells:
        sink = int(result["region"][i]) == Region.SINK and not result["was_chaotic"][i]
        equilibrium = result["equilibrium"][i] if sink else None
        title = rf"${speed.symbol} = {number(result['Omega1'][i])}\,{unit_text(speed.unit)}$"
        found.append(Powered(title, Trace(model, result["time"], result["orbit"][i], APPROACH, equilibrium), power[i]))
    return found


def power_of(result: Result) -> Observable:
    """Return the Casimir power of a result's model."""
    return next(known for known in result.sweep.model.observables if known.name == "casimir_power")


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw all four."""
    result = runs["figure_08"]
    return make_power_figure(orbits(result, findings.data, range(len(findings.data))), power_of(result))


FIGURE = Item(
    name="figure_08",
    title="Orbits (left) and their Casimir power (right) at four rotor speeds",
    configs=("figure_08",),
    analyse=analyse,
    draw=draw,
)
