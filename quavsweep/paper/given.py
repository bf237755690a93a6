"""What the paper takes as given, beside what is integrated here: starts, cases, ranges, an assumption."""

from __future__ import annotations

import numpy as np

from quavsweep.paper.item import Findings, Item
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs

NAME = "given"
CASES = "cases"
SWEEPS = {"figure_05": ("Omega1", "c"), "figure_09": ("Omega1",)}  # with the axes whose ends are printed


def analyse(runs: Runs) -> Findings:
    """Read starts, cases and ranges from the configs that are run."""
    flight, start = runs.sweep(CASES), runs.sweep("figure_08")
    craft = {**flight.model.defaults, **flight.parameters}
    computed = {f"start.{name}": _given(start.config.initial[name]) for name in start.model.state_names}
    computed |= {name: _given(craft[name]) for name in ("Omega1", "c", "m", "g", "b")}
    computed["height"] = _given(flight.config.initial["z"])
    computed |= {f"hover.{name}": _given(flight.config.initial[name]) for name in ("phi", "theta", "psi")}
    (cases,) = flight.grid.axes
    for i in range(len(cases)):
        values = {**craft, **cases.at(i)}
        computed |= {f"case{i + 1}.{name}": _given(values[name]) for name in ("Ix", "Iy", "Iz", "Ir")}
    for config, names in SWEEPS.items():
        axes = {axis.name: axis.values for axis in runs.sweep(config).grid.axes}
        computed |= {f"{config}.{n}.{end}": _given(f(axes[n])) for n in names for end, f in ENDS.items()}
    computed["figure_10.Ix"] = _given(runs.sweep("figure_10").parameters["Ix"])
    (hits,) = runs["figure_08"]["cycle_hits"][-1:]
    computed["multiperiodic"] = Computed(
        "multiperiodic" if hits > 1 else "periodic", note=f"{hits} maxima of p in a period"
    )
    computed["symmetry"] = Computed("x-z and y-z", note="in (12) arms are along x and y, rotors' axes along z")
    return Findings(computed)


ENDS = {"low": np.min, "high": np.max}


def _given(value: float) -> Computed:
    return Computed(float(value), given=True)


ITEM = Item(NAME, "What the paper takes as given, and is taken so here", analyse, configs=("figure_08",))
