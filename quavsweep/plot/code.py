"""What the codes of a result mean, and their colours in figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from quavsweep.codes import REGION, STATUS, Code, Region, Status

if TYPE_CHECKING:
    from quavsweep.result import Result

VOID = "#4d4d4d"  # a computed cell that has no such number
_COLOUR = {Region(code.number): code.colour for code in REGION}
_STATUS = {
    Status.NOT_COMPUTED: _COLOUR[Region.NONE],
    Status.TIME_OVER: _COLOUR[Region.UNDECIDED],
    Status.ENDED_SINK: _COLOUR[Region.SINK],
    Status.ENDED_CYCLE: _COLOUR[Region.PERIODIC],
    Status.DIVERGED: _COLOUR[Region.UNBOUNDED],
    Status.LEFT_DOMAIN: _COLOUR[Region.QUASI_PERIODIC],
    Status.FRAME_DEGENERATE: _COLOUR[Region.SADDLE],
    Status.FAILED: _COLOUR[Region.CHAOS],
}
WAS_CHAOTIC = (
    Code(0, "not_chaotic", "not chaotic", "#d9d9d9"),
    Code(1, "was_chaotic", "was chaotic", _COLOUR[Region.CHAOS]),
)
_TABLES = {
    "region": REGION,
    "status": tuple(
        Code(code.number, code.name, code.name.replace("_", " "), _STATUS[Status(code.number)]) for code in STATUS
    ),
    "was_chaotic": WAS_CHAOTIC,
}


def codes_of(result: Result, variable: str) -> tuple[Code, ...]:
    """Return the codes of a variable with their colours, none if its numbers are no codes."""
    attributes = result.stored.attributes.get(variable, {})
    if variable in _TABLES:
        return _TABLES[variable]
    if "flag_values" not in attributes:
        return ()
    colours = list(_COLOUR.values())
    flags = zip(np.atleast_1d(attributes["flag_values"]), str(attributes["flag_meanings"]).split(), strict=True)
    return tuple(Code(int(n), name, name.replace("_", " "), colours[int(n) % len(colours)]) for n, name in flags)


def code_colours(codes: tuple[Code, ...]) -> tuple[ListedColormap, BoundaryNorm]:
    """Return the colour map and norm that give each code its colour."""
    colours = ListedColormap([code.colour for code in codes])
    return colours, BoundaryNorm([code.number - 0.5 for code in codes] + [codes[-1].number + 0.5], len(codes))


def code_handles(values: np.ndarray, codes: tuple[Code, ...], todo: np.ndarray) -> list[Artist]:
    """Return a legend's patches for the codes that are present, hatched for cells that are not computed."""
    present = [code for code in codes if (~todo & (values == code.number)).any()]
    return [*(patch(code.colour, code.meaning) for code in present), *mask_handles(todo, np.zeros_like(todo))]


def mask_handles(todo: np.ndarray, void: np.ndarray) -> list[Artist]:
    """Return a legend's patches for cells without a number and cells that are not computed, if there are any."""
    handles: list[Artist] = [patch(VOID, "no value")] if void.any() else []
    if todo.any():
        handles.append(patch("white", "not computed", edgecolor="0.4", hatch="////"))
    return handles


def patch(colour: str, text: str, edgecolor: str = "black", hatch: str | None = None) -> Patch:
    """Return a coloured box for a legend."""
    return Patch(facecolor=colour, edgecolor=edgecolor, linewidth=0.4, hatch=hatch, label=text)
