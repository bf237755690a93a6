"""What stands over a figure: of a single cell, of axes that were left out, of a horizon."""

from __future__ import annotations

from collections.abc import Container, Sequence
from typing import TYPE_CHECKING

from quavsweep.codes import REGION
from quavsweep.config import Sweep
from quavsweep.plot.style import number, symbol, text_length, unit_text
from quavsweep.plot.thin import thinned_text

if TYPE_CHECKING:
    from quavsweep.result import Result

PER_INCH = 15  # characters
LINE = 0.16  # inches
FEW = 3  # initial values that are written down even if they are zero


def cell_title(
    sweep: Sweep,
    initial: Sequence[float],
    region: int,
    width: float,
    named: Container[str] = (),
    horizon: str = "",
) -> str:
    """Return model, parameters, initial state, region and a horizon, in lines of so many inches.

    Parameters are written down that differ from the model's defaults or are among those named.
    """
    model, parameters = sweep.model, sweep.parameters
    told = [name for name, default in model.defaults.items() if parameters[name] != default or name in named]
    changed = [_assignment(symbol(model, name)[1:-1], parameters[name], model.quantity(name).unit) for name in told]
    starts = [
        _assignment(f"{state.symbol or state.name}(0)", value, state.unit)
        for state, value in zip(model.states, initial, strict=True)
        if value or len(initial) <= FEW
    ]
    parts = [model.name.replace("_", " "), *changed, *starts, REGION[region].meaning, horizon]
    return _lines(parts, int(PER_INCH * width))


def fixed_title(sweep: Sweep, names: Sequence[str], width: float, horizon: str = "") -> str:
    """Return the values of axes that were left out, and a horizon, in lines of so many inches; empty without any."""
    values = {**sweep.parameters, **sweep.config.initial}
    quantities = [(sweep.model.quantity(name), symbol(sweep.model, name)[1:-1], values[name]) for name in names]
    assignments = [_assignment(text, value, quantity.unit) for quantity, text, value in quantities]
    return _lines([*assignments, horizon], int(PER_INCH * width))


def horizon_text(result: Result) -> str:
    """Return which horizon a result is asked for, and what is unknown there; empty where it is that of the run."""
    if result.horizon is None:
        return ""
    unknown = "; chaos there is undecided" if "comment" in result.stored.attributes["region"] else ""
    unit = unit_text(result.sweep.model.time_unit)
    return f"horizon ${number(result.horizon)}" + (rf"\,{unit}$" if unit else "$") + unknown


def seen_text(result: Result) -> str:
    """Return at which horizon a result is seen, and how many of its cells; empty where it is all of the run."""
    return ", ".join(filter(None, (horizon_text(result), thinned_text(result))))


def _assignment(name: str, value: float, unit: str) -> str:
    """Return a quantity with its value and unit."""
    unit = unit_text(unit)
    return f"${name} = {number(value)}" + (rf"\,{unit}$" if unit else "$")


def _lines(parts: list[str], width: int) -> str:
    """Return those parts of a title that are not empty, with commas between them, in lines of so many characters."""
    lines, parts = [""], [part for part in parts if part]
    for part in [*(f"{part}," for part in parts[:-1]), *parts[-1:]]:
        if lines[-1] and text_length(lines[-1]) + text_length(part) >= width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + part
    return "\n".join(lines)
