"""Outputs and their dimensions as data, and the evidence that every sweep records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from quavsweep.codes import CERTIFICATE, CYCLE_SYMMETRY, REGION, STATUS, Code


@dataclass(frozen=True)
class Variable:
    """An output: its name, dimensions beyond the cell, type, unit, meaning, and its codes if it is coded."""

    name: str
    dims: tuple[str, ...]
    dtype: str
    unit: str
    meaning: str
    codes: tuple[Code, ...] = ()

    @property
    def fill(self) -> float | int:
        """The value of a cell where it does not apply: NaN, or 0 for integers."""
        return 0 if np.dtype(self.dtype).kind in "iu" else np.nan

    def shape(self, n: int, extents: Mapping[str, int]) -> tuple[int, ...]:
        """Return the shape for n cells."""
        return (n, *(extents[dim] for dim in self.dims))

    def empty(self, n: int, extents: Mapping[str, int]) -> np.ndarray:
        """Return the array of n cells to which nothing applies yet."""
        return np.full(self.shape(n, extents), self.fill, dtype=self.dtype)


@dataclass(frozen=True)
class Dimension:
    """A dimension beyond the axes: its coordinate, what it counts, and a unit for all of it or for each component."""

    name: str
    values: np.ndarray
    meaning: str
    unit: str = ""
    component_units: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.values)


Evidence = dict[str, np.ndarray]  # by a variable's name, cells first

STATUS_VARIABLE = Variable("status", (), "int8", "1", "how the integration ended", STATUS)
REGION_VARIABLE = Variable("region", (), "int8", "1", "what the orbit does in the end", REGION)

BASE = (
    Variable("cell", (), "int64", "1", "number of the cell in C order of the axes"),
    STATUS_VARIABLE,
    Variable("steps", (), "int64", "1", "steps integrated"),
    Variable("state", ("state",), "float64", "", "state after them"),
    Variable("certificate", (), "int8", "1", "what is known of the end of the orbit", CERTIFICATE),
    Variable("certified_steps", (), "int64", "1", "steps at the first look inside the certified neighbourhood"),
    Variable("settled_steps", (), "int64", "1", "steps at the look before"),
    Variable("equilibrium", ("state",), "float64", "", "the equilibrium in which the orbit ends"),
    Variable("eigenvalue_re", ("state",), "float64", "1/time", "real parts of the eigenvalues there, largest first"),
    Variable("eigenvalue_im", ("state",), "float64", "1/time", "imaginary parts of the eigenvalues there"),
    Variable("rest_steps", (), "int64", "1", "steps at the first look of the rest on an equilibrium that lasts"),
    Variable("close_steps", (), "int64", "1", "steps at the first look at which a stable cycle closes near the orbit"),
    Variable("period", (), "float64", "time", "period of the cycle in which the orbit ends"),
    Variable("cycle_hits", (), "int32", "1", "hits of the section per period"),
    Variable("cycle_symmetry", (), "int8", "1", "how the cycle lies to the model's symmetries", CYCLE_SYMMETRY),
    Variable("cycle_point", ("state",), "float64", "state", "the point of the cycle on the section that comes last"),
    Variable("multiplier_re", ("state",), "float64", "1", "real parts of the Floquet multipliers, largest size first"),
    Variable("multiplier_im", ("state",), "float64", "1", "imaginary parts of the Floquet multipliers"),
)
