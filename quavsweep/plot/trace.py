"""Trace: the orbit of one cell, with what is known of its parts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from quavsweep.models import Model

EARLY, LATE = "#6baed6", "#08306b"  # pale and dark, of one colour
MARK = "#d55e00"


@dataclass(frozen=True)
class Trace:
    """The orbit of one cell.

    Parameters
    ----------
    model : Model
    time : (n,) float64
    states : (n, D) float64
    transient : float
        Time until which it is on its way.
    equilibrium : (D,) float64, optional
        Where it ends.
    """

    model: Model
    time: np.ndarray
    states: np.ndarray
    transient: float
    equilibrium: np.ndarray | None = None

    @cached_property
    def shown(self) -> np.ndarray:
        """The states, NaN from where they have left the bound of the model."""
        with np.errstate(invalid="ignore"):
            good = (np.abs(self.states) <= self.model.bound).all(axis=1)
        return np.where(good[:, None], self.states, np.nan)

    @property
    def transient_seen(self) -> bool:
        """Whether the transient ends within the orbit."""
        return len(self.time) > 0 and bool(self.time[0] < self.transient < self.time[-1])

    @property
    def late(self) -> int:
        """Where the part begins that shows how the orbit ends: behind the transient, or half-way if it ended before."""
        behind = int(np.searchsorted(self.time, self.transient))
        return behind if behind < len(self.time) - 1 else len(self.time) // 2

    @property
    def part_names(self) -> tuple[str, str]:
        """What the parts before and behind that are called."""
        return ("transient", "after it") if self.transient_seen else ("first half", "last half")
