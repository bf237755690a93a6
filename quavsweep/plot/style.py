"""What all figures share: sizes, fonts, labels with symbols and units."""

from __future__ import annotations

import re
import textwrap
from contextlib import AbstractContextManager
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from quavsweep.models import Model

PANEL = (3.5, 2.9)  # inches; a column of a journal is about 3.5 wide
PAGE = 7.0  # inches; both columns
SMALL = 7  # points; legends and notes
LABEL_WIDTH = 36  # characters that fit along the side of a panel
SETTINGS = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "legend.fontsize": SMALL,
    "mathtext.fontset": "dejavusans",
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "lines.linewidth": 0.8,
    "hatch.linewidth": 0.5,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "quavsweep",
    "savefig.dpi": 300,
}
LINES = ("black", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#999999")  # Okabe and Ito
DASHES: tuple[Any, ...] = ("-", "--", (0, (1, 1)), "-.", (0, (6, 1.5)), (0, (3, 1, 1, 1, 1, 1)))


def line_colours(count: int) -> list[Any]:
    """Return the colours of some lines: such that are told apart, or a sequence where there are many."""
    if count <= len(LINES):
        return list(LINES[:count])
    return list(mpl.colormaps["viridis"](np.linspace(0.0, 0.9, count)))


def style() -> AbstractContextManager[Any]:
    """Return the context in which figures are made and saved."""
    return mpl.rc_context(SETTINGS)


def unit_text(unit: str) -> str:
    """Return a unit in LaTeX without dollars: `kg m2` becomes `kg m^2`, `1/s` and `s-1` become s^-1."""
    over, _, under = unit.partition("/")
    factors = [_power(factor, 1) for factor in over.split() if factor != "1"]
    return r"\,".join([*factors, *(_power(factor, -1) for factor in under.split())])


def _power(factor: str, sign: int) -> str:
    base = factor.rstrip("-0123456789")
    power = sign * int(factor[len(base) :] or 1)
    return rf"\mathrm{{{base}}}" + ("" if power == 1 else f"^{{{power}}}")


def with_unit(text: str, unit: str, power: int = 0) -> str:
    """Return a label: a text, and in brackets its unit and the power of ten that its numbers lack."""
    scale = rf"10^{{{power}}}" if power else ""
    inside = r"\,".join(part for part in (scale, unit_text(unit)) if part)
    return text + (f" (${inside}$)" if inside else "")


def symbol(model: Model, name: str) -> str:
    """Return the symbol of a state or parameter, in dollars."""
    return f"${model.quantity(name).symbol or name}$"


def label(model: Model, name: str, power: int = 0) -> str:
    """Return the label of a state or parameter: its symbol and unit, with a power of ten that its values lack."""
    return with_unit(symbol(model, name), model.quantity(name).unit, power)


def rate_unit(model: Model) -> str:
    """Return the unit of a rate in the model's time."""
    return "1" if model.time_unit == "1" else f"1/{model.time_unit}"


def power_of(values: np.ndarray) -> int:
    """Return the power of ten that goes into the label of an axis, 0 where its numbers are handy as they are."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max()) if finite.size else 0.0
    return int(np.floor(np.log10(largest))) if largest and not 0.01 <= largest < 1e5 else 0


def number(value: float) -> str:
    """Return a number for a label or title, powers of ten as such."""
    mantissa, _, exponent = f"{value:.4g}".partition("e")
    if not exponent:
        return mantissa
    return rf"{mantissa}\times 10^{{{int(exponent)}}}" if mantissa not in ("1", "-1") else f"10^{{{int(exponent)}}}"


def measured(value: float, error: float) -> str:
    """Return a value with its standard error, as many digits of it as that allows."""
    if not np.isfinite(value):
        return r"\mathrm{no\ value}"
    if not np.isfinite(error) or error <= 0:
        return number(value)
    digits = 1 - int(np.floor(np.log10(error)))
    exponent = int(np.floor(np.log10(max(abs(value), error))))
    if not (0 <= digits <= 7 or 0 <= exponent <= 3):
        scale, digits = 10.0**exponent, max(0, digits + exponent)
        return rf"({value / scale:.{digits}f} \pm {error / scale:.{digits}f})\times 10^{{{exponent}}}"
    digits = max(0, digits)
    return rf"{value:.{digits}f} \pm {error:.{digits}f}"


def plain(text: str) -> str:
    """Return a user's text such that figures show it as it is: dollars are no formulas, nor `_` a private name."""
    return (" " if text.startswith("_") else "") + text.replace("$", r"\$")


def text_length(text: str) -> int:
    """Return how many characters of a text are seen, about."""
    return len(re.sub(r"[${}_^]", "", re.sub(r"\\(mathrm|,)", "", re.sub(r"\\(?!mathrm)[A-Za-z]+", "x", text))))


def set_room(figure: Figure, inches: float) -> None:
    """Leave some inches around each panel of a figure with a constrained layout."""
    engine: Any = figure.get_layout_engine()
    engine.set(h_pad=inches, w_pad=inches)


def say(axes: Axes, text: str) -> None:
    """Say why axes are empty."""
    white = {"facecolor": "white", "linewidth": 0.0, "pad": 2.0}
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color="0.3", bbox=white)


def wrapped(text: str, width: int = LABEL_WIDTH) -> str:
    """Return a text without formulas in lines of at most so many characters."""
    return text if "$" in text else textwrap.fill(text, width)
