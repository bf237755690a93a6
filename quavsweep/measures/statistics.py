"""The measure `statistics`: mean with its error, extremes and changes of sign of states and observables."""

from __future__ import annotations

from typing import Self

from pydantic import Field

from quavsweep.clock import Clock
from quavsweep.measures.dense import DenseMeasure
from quavsweep.measures.lyapunov import counted
from quavsweep.measures.measure import Problem, beyond_the_end, listed, problem_of_list
from quavsweep.measures.variable import Dimension, Variable
from quavsweep.models import Model


class Statistics(DenseMeasure):
    """Mean, extremes and changes of sign from `after` to the end of the run; no cell ends before that."""

    of: list[str] = Field(min_length=1, description="the states and observables")
    after: float | None = Field(default=None, ge=0, description="from then on; default the end of the transient")

    @property
    def watched(self) -> tuple[str, ...]:
        """The states and observables."""
        return tuple(self.of)

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """Integrals over batches, so that a longer run can go on with them, and what goes into the result."""
        integral = Variable("statistic_sum", ("batch", "statistic_of"), "float64", "", "integral over steps, in steps")
        return (integral, *self.outputs)

    @property
    def outputs(self) -> tuple[Variable, ...]:
        """Mean, its standard error, extremes and changes of sign."""
        of = ("statistic_of",)
        return (
            Variable("statistic_mean", of, "float64", "state", "mean over time, by the trapezoidal rule over steps"),
            Variable("statistic_mean_se", of, "float64", "state", "its standard error, from means of batches"),
            Variable("statistic_min", of, "float64", "state", "least value at a step"),
            Variable("statistic_max", of, "float64", "state", "largest value at a step"),
            Variable("sign_changes", of, "int32", "1", "changes of sign from step to step"),
        )

    def dimensions(self, model: Model, clock: Clock) -> tuple[Dimension, ...]:
        """Return batches and quantities."""
        batches = counted("batch", clock.segments * clock.segment_batches, "number of the batch")
        return batches, listed("statistic_of", self.of, model)

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with quantities or time."""
        if problem := problem_of_list(self.of, model) or beyond_the_end(self.after, "after", clock):
            return problem
        if self.after is not None and clock.steps_of(self.after) >= clock.steps:
            return Problem("after", f"{self.after:g} is the end of the run", "a smaller one")
        return None

    def first(self, clock: Clock) -> int:
        """Return the step from which on it looks."""
        return clock.transient_steps if self.after is None else clock.steps_of(self.after)

    def rounded(self, model: Model, clock: Clock) -> Self:
        """Return it with whole steps."""
        return self.model_copy(update={"after": self.first(clock) * clock.dt})

    def hold(self, clock: Clock) -> int:
        """Return the last step."""
        return clock.steps
