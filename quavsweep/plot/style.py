"""What all figures share: sizes, fonts, labels with symbols and units, colours of codes."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

import matplotlib as mpl
from matplotlib.colors import BoundaryNorm, ListedColormap

from quavsweep.codes import Code
from quavsweep.models import Model

PANEL = (3.5, 2.9)  # inches; a column of a journal is about 3.5 wide
SETTINGS = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "legend.fontsize": 7,
    "mathtext.fontset": "dejavusans",
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "hatch.linewidth": 0.5,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "quavsweep",
    "savefig.dpi": 300,
}


def style() -> AbstractContextManager[Any]:
    """Return the context in which figures are made and saved."""
    return mpl.rc_context(SETTINGS)


def unit_text(unit: str) -> str:
    """Return a unit in LaTeX without dollars: `kg m2` becomes `kg m^2`, `1/s` becomes s^-1."""
    over, _, under = unit.partition("/")
    factors = [_power(factor, 1) for factor in over.split() if factor != "1"]
    return r"\,".join([*factors, *(_power(factor, -1) for factor in under.split())])


def _power(factor: str, sign: int) -> str:
    base = factor.rstrip("0123456789")
    power = sign * int(factor[len(base) :] or 1)
    return rf"\mathrm{{{base}}}" + ("" if power == 1 else f"^{{{power}}}")


def label(model: Model, name: str, power: int = 0) -> str:
    """Return the label of a state or parameter: its symbol and unit, with a power of ten that its values lack."""
    quantity = model.quantity(name)
    scale = rf"10^{{{power}}}" if power else ""
    unit = "" if quantity.unit == "1" else unit_text(quantity.unit)
    inside = r"\,".join(part for part in (scale, unit) if part)
    return f"${quantity.symbol or name}$" + (f" (${inside}$)" if inside else "")


def rate_label(model: Model, symbol: str) -> str:
    """Return the label of a rate in the model's time."""
    return f"${symbol}$" if model.time_unit == "1" else f"${symbol}$ (${unit_text('1/' + model.time_unit)}$)"


def code_colours(codes: tuple[Code, ...]) -> tuple[ListedColormap, BoundaryNorm]:
    """Return the colour map and norm that give each code its colour."""
    colours = ListedColormap([code.colour for code in codes])
    return colours, BoundaryNorm([code.number - 0.5 for code in codes] + [codes[-1].number + 0.5], len(codes))
