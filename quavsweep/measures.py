"""What is recorded per cell: declared schemas. Base evidence first, then the measures that a config may ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from quavsweep.codes import CERTIFICATE, REGION, STATUS, Code


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
)


class Lyapunov(BaseModel):
    """Lyapunov exponents by Benettin's method: tangent vectors, orthonormalised every `block` steps."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)

    exponents: int = Field(default=3, ge=1, description="number of exponents, largest first")
    block: int = Field(default=25, ge=1, le=100_000, description="steps between two orthonormalisations")
    batch: float | None = Field(default=None, gt=0, description="window of the error bars, in the model's time")

    @property
    def vectors(self) -> int:
        """Tangent vectors that the kernel has to carry."""
        return self.exponents

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """What it records, beside the base evidence."""
        return (
            Variable("frame", ("exponent", "state"), "float64", "1", "orthonormal tangent vectors at the end"),
            Variable("growth", ("batch", "exponent"), "float32", "1", "ln of the stretching in each batch"),
            Variable("growth_total", ("segment", "exponent"), "float64", "1", "ln of the stretching from t = 0"),
        )


class Measures(BaseModel):
    """The measures of a sweep."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    lyapunov: Lyapunov | None = Field(default=None, description="Lyapunov exponents with error bars")

    @model_validator(mode="before")
    @classmethod
    def _named_is_meant(cls, data: Any) -> Any:
        """Read a measure that is named without options as one with the defaults."""
        return {k: {} if v is None else v for k, v in data.items()} if isinstance(data, dict) else data

    @property
    def chosen(self) -> tuple[Lyapunov, ...]:
        """The measures asked for."""
        return tuple(m for m in (self.lyapunov,) if m is not None)

    @property
    def vectors(self) -> int:
        """Tangent vectors that the kernel has to carry, K."""
        return max((measure.vectors for measure in self.chosen), default=0)

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """All that a shard records per cell."""
        return (*BASE, *(variable for measure in self.chosen for variable in measure.evidence))
