"""Quantity: a number, or samples, per cell, with all that a figure has to say of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from quavsweep.codes import Code
from quavsweep.plot.style import with_unit


@dataclass(frozen=True)
class Quantity:
    """A component of a variable over the grid of a result, ready to be drawn.

    Parameters
    ----------
    name : str
        As a user asks for it: `region`, `final_state.p`, `lyapunov.2`.
    values : (axes...) or (axes..., samples) array
    text, unit : str
        What the numbers are.
    part : str
        What the component is among those of the variable, in a legend; empty if there is only one.
    todo : (axes...) bool
        Cells that are not computed.
    codes : tuple of Code
        What the numbers mean, where they are codes.
    rate : bool
        Whether the numbers are rates, whose sign matters.
    error : (axes...) float64, optional
        Their standard errors.
    bound : (axes...) float64, optional
        What the number exceeds, where it is not known.
    log : bool
        Whether the numbers are drawn on a logarithmic scale.
    share : bool
        Whether they are shares, from 0 to 1.
    """

    name: str
    values: np.ndarray
    text: str
    unit: str
    part: str
    todo: np.ndarray
    codes: tuple[Code, ...] = ()
    rate: bool = False
    error: np.ndarray | None = None
    bound: np.ndarray | None = None
    log: bool = False
    share: bool = False

    @property
    def sampled(self) -> bool:
        """Whether there are many numbers per cell."""
        return self.values.ndim > self.todo.ndim

    @cached_property
    def shown(self) -> np.ndarray:
        """The numbers of computed cells, NaN elsewhere, float64."""
        todo = self.todo[..., None] if self.sampled else self.todo
        return np.where(todo | ~np.isfinite(self.values), np.nan, self.values)

    @property
    def bounded(self) -> bool:
        """Whether there are bounds for numbers that are not known."""
        return self.bound is not None and bool(np.isfinite(self.bound).any())

    @property
    def empty(self) -> bool:
        """Whether there is neither a number nor a bound."""
        return not self.bounded and not np.isfinite(self.shown).any()

    @property
    def void(self) -> np.ndarray:
        """Computed cells that have no number, (axes...) bool."""
        if self.values.dtype.kind in "iu":
            return np.zeros_like(self.todo)
        empty = np.isnan(self.shown if self.bound is None else np.fmax(self.shown, self.bound))
        return np.asarray(~self.todo & (empty.all(axis=-1) if self.sampled else empty))

    def label(self, power: int = 0) -> str:
        """Return text and unit, with a power of ten that the numbers lack."""
        return with_unit(self.text, self.unit, power)
