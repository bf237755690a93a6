"""Attractors in figures: a colour for each of a table, and what it is; starts without one show their region."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex

from quavsweep.analysis.attractor import OTHER
from quavsweep.codes import REGION, Certificate, Code
from quavsweep.plot.style import number, symbol

if TYPE_CHECKING:
    from quavsweep.result import Result

REGIONS = 100  # what is added to the code of a region, to tell it from the number of an attractor
# Okabe and Ito's, less what is too near to the colours of regions that are no attractor's.
COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#f0e442")
KINDS = {Certificate.SINK: "sink", Certificate.CYCLE: "cycle"}
FEW = 3  # states up to which a point is written out


def attractor_values(result: Result) -> np.ndarray:
    """Return of each cell the number of its attractor, or 100 and the code of its region where it has none."""
    attractor, region = result["attractor"].astype(np.int16), result["region"]
    return np.where(attractor == 0, REGIONS + region, attractor)


def attractor_codes(result: Result) -> tuple[Code, ...]:
    """Return the codes of these values; attractors have names only where there is a single table."""
    single = result["attractor_kind"].ndim == 1
    rows = range(result["attractor_kind"].shape[-1])
    numbered = [
        Code(i + 1, f"attractor_{i + 1}", _named(result, i) if single else f"attractor {i + 1}", _colour(i))
        for i in rows
    ]
    regions = [Code(REGIONS + code.number, code.name, code.meaning, code.colour) for code in REGION]
    return (Code(OTHER, "other", "another attractor", "#d9d9d9"), *numbered, *regions)


def _colour(index: int) -> str:
    if index < len(COLOURS):
        return COLOURS[index]
    return str(to_hex(mpl.colormaps["viridis"]((index - len(COLOURS) + 0.5) / 10.0)))


def _named(result: Result, row: int) -> str:
    """Return what an attractor is: its kind and a point on it."""
    kind, model = int(result["attractor_kind"][row]), result.sweep.model
    if kind == Certificate.NONE:
        return ""
    names = [symbol(model, name)[1:-1] for name in model.state_names[:FEW]]
    point = [f"{{{number(float(f'{value:.3g}'))}}}" for value in result["attractor_point"][row][:FEW]]
    more = ", ..." if len(model.states) > FEW else ""
    through = "at" if kind == Certificate.SINK else "through"
    return f"{KINDS[Certificate(kind)]} {through} $({', '.join(names)}{more}) = ({', '.join(point)}{more})$"
