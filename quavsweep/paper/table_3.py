"""Table 3: equilibria, eigenvalues and types at three speeds of the front rotors."""

from __future__ import annotations

import numpy as np

from quavsweep.analysis.equilibrium_search import Equilibria, find_equilibria
from quavsweep.models import load_model
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs

MODEL = load_model("quadrotor_yaw")
SPEEDS = tuple(dict.fromkeys(float(row.key.partition(".E1")[0]) for row in read_printed("table_3") if ".E1" in row.key))


def _analyse(runs: Runs) -> Findings:
    computed: dict[str, Computed] = {}
    rows, complete = [], True
    for speed in SPEEDS:
        found = find_equilibria(MODEL, {"Omega1": speed})
        complete &= found.complete
        axis = int(np.argmin(np.abs(found.states[:, 0])))
        side = int(np.argmax(found.states[:, 0]))
        for name, k in (("E1", axis), ("side", side)):
            computed.update(_row(f"{speed:g}.{name}", found, k))
        rows += [
            (f"{speed:g}", _vector(u), _spectrum(values), kind)
            for u, values, kind in zip(found.states, found.eigenvalues, found.types, strict=True)
        ]
    head = ("Omega1 (rad/s)", "(p, q, r) (rad/s)", "eigenvalues (1/s)", "type")
    return Findings(computed, tables=[Table("Equilibria" + (", proved to be all" if complete else ""), head, rows)])


def _row(key: str, found: Equilibria, k: int) -> dict[str, Computed]:
    """Return state, eigenvalues and type of one equilibrium."""
    values = found.eigenvalues[k]
    real = sorted(values[values.imag == 0].real, reverse=True)
    pair = values[values.imag > 0]
    numbers = dict(zip(("p", "q", "r"), found.states[k], strict=True))
    numbers |= {f"lambda{n + 1}": value for n, value in enumerate(real)}
    if len(pair):
        numbers |= {"re": pair[0].real, "im": pair[0].imag}
    computed = {f"{key}.{name}": Computed(float(x)) for name, x in numbers.items()}
    return {**computed, f"{key}.type": Computed(found.types[k])}


def _vector(u: np.ndarray) -> str:
    return "(" + ", ".join(f"{x:.4f}" for x in u) + ")"


def _spectrum(values: np.ndarray) -> str:
    """Return eigenvalues, a pair as one."""
    return ", ".join(f"{x.real:.4f}" + (f" ± {x.imag:.4f}i" if x.imag else "") for x in values if x.imag >= 0)


FIGURE = Item(name="table_3", title="Equilibria and eigenvalues of the yaw system", analyse=_analyse)
