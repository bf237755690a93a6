"""The measure `verdict`: one tangent vector beyond the end, for cells that were integrated without any."""

from __future__ import annotations

from pydantic import Field

from quavsweep.clock import Clock
from quavsweep.measures.lyapunov import counted
from quavsweep.measures.measure import Measure
from quavsweep.measures.variable import Dimension, Variable
from quavsweep.models import Model


class Verdict(Measure):
    """Growth of one tangent vector beyond the end of the run, for cells without a certificate; nothing else of it."""

    batches: int = Field(default=256, ge=8, le=4096, description="batches over which the growth is recorded")

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """The growth, NaN where a certificate tells the end."""
        return (Variable("late_growth", ("late",), "float32", "1", "ln of the stretching in batches beyond the end"),)

    @property
    def outputs(self) -> tuple[Variable, ...]:
        """Nothing: the classification reads it."""
        return ()

    def dimensions(self, model: Model, clock: Clock) -> tuple[Dimension, ...]:
        """Return the batches, counted from 1."""
        return (counted("late", self.batches, "number of the batch beyond the end"),)
