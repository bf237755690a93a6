"""The measure `lyapunov`: exponents with error bars."""

from __future__ import annotations

from typing import Self

import numpy as np
from pydantic import Field

from quavsweep.clock import Clock
from quavsweep.measures.measure import Measure, Problem
from quavsweep.measures.variable import Dimension, Variable
from quavsweep.models import Model


class Lyapunov(Measure):
    """Lyapunov exponents by Benettin's method: tangent vectors, orthonormalised every `block` steps."""

    exponents: int = Field(default=3, ge=1, description="number of exponents, largest first")
    block: int = Field(default=25, ge=1, le=100_000, description="steps between two orthonormalisations")
    batch: float | None = Field(default=None, gt=0, description="window of the error bars, in the model's time")
    last_from_trace: bool = Field(default=False, description="take the last exponent from the sum, the mean divergence")

    @property
    def vectors(self) -> int:
        """Tangent vectors that the kernel has to carry."""
        return self.exponents - self.last_from_trace

    @property
    def trace(self) -> bool:
        """Whether the kernel has to integrate the trace of the Jacobian."""
        return self.last_from_trace

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """What it records, beside the base evidence."""
        return (
            Variable("frame", ("vector", "state"), "float64", "1", "orthonormal tangent vectors at the end"),
            Variable("growth", ("batch", "exponent"), "float32", "1", "ln of the stretching in each batch"),
            Variable("growth_total", ("segment", "exponent"), "float64", "1", "ln of the stretching from t = 0"),
            Variable("divergence", ("segment",), "float64", "1", "integral of the divergence from t = 0"),
        )

    @property
    def outputs(self) -> tuple[Variable, ...]:
        """Nothing: exponents are made of its evidence by the classification."""
        return ()

    def dimensions(self, model: Model, clock: Clock) -> tuple[Dimension, ...]:
        """Return exponent, batch and segment, counted from 1."""
        return (
            counted("exponent", self.exponents, "number of the exponent, largest first"),
            counted("vector", self.vectors, "number of the tangent vector"),
            counted("batch", clock.segments * clock.segment_batches, "number of the batch"),
            counted("segment", clock.segments, "number of the segment"),
        )

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with its options: more exponents than states, or too few for their sum to be known."""
        most = len(model.states)
        if self.exponents > most:
            return Problem("exponents", f"{model.name} has {most} states", f"1 to {most} exponents")
        if self.last_from_trace and self.exponents < most:
            what = f"the sum of all {most} exponents gives the last one, but {self.exponents} are asked for"
            return Problem("last_from_trace", what, f"exponents: {most}, or last_from_trace: false")
        return None

    def rounded(self, model: Model, clock: Clock) -> Self:
        """Return it with the length of a batch that the clock uses."""
        return self.model_copy(update={"batch": clock.batch_steps * clock.dt})


def counted(name: str, length: int, meaning: str) -> Dimension:
    """Return a dimension whose coordinate counts from 1."""
    return Dimension(name, np.arange(1, length + 1, dtype=np.int32), meaning)
