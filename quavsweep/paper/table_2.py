"""Table 2: the parameters of the quadrotor, which the models' defaults are."""

from __future__ import annotations

from quavsweep.models.craft import TABLE_2
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs

NAME = "table_2"
UNIT = ".unit"  # behind the keys of units
READ = {"N/m/s": "N s/m"}  # a printed unit, as it makes sense
HEAD = ("parameter", "value", "unit in the equations", "unit as printed", "meaning")


def analyse(runs: Runs) -> Findings:
    """Compare the models' defaults, and the units that their equations need."""
    printed = {row.key.removesuffix(UNIT): row.paper for row in read_printed(NAME) if row.key.endswith(UNIT)}
    rows = [(p.name, f"{p.default:g}", p.unit, printed.get(p.name, ""), p.meaning) for p in TABLE_2.values()]
    differing = ", ".join(name for name, _, unit, other, _ in rows if READ.get(other, other) != unit)
    text = f"The printed units of {differing} do not fit the equations; N/m/s of k1 to k3 does if read as N/(m/s)."
    computed = {name: Computed(p.default, given=True) for name, p in TABLE_2.items()}
    for name, parameter in TABLE_2.items():
        fits = READ.get(printed[name], printed[name]) == parameter.unit
        note = f"read as {parameter.unit}" if fits and printed[name] != parameter.unit else ""
        computed[name + UNIT] = Computed(printed[name] if fits else parameter.unit, note=note)
    return Findings(computed, tables=(Table("Parameters and their units", HEAD, rows),), text=text)


TABLE = Item(NAME, "Parameters of the quadrotor", analyse)
