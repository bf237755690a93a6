"""What every measure declares: its options, what it needs of the integration, and what it records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from pydantic import BaseModel, ConfigDict

from quavsweep.clock import Clock
from quavsweep.measures.variable import Dimension, Variable
from quavsweep.models import Model


@dataclass(frozen=True)
class Problem:
    """What is wrong with an option: its key within the measure, what, and what is possible."""

    key: str
    what: str
    possible: str


class Measure(BaseModel):
    """A measure as a config asks for it; its fields are its options.

    Attributes
    ----------
    dense : bool
        Whether it must see the state after every step.
    """

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)

    dense: ClassVar[bool] = False

    @property
    def vectors(self) -> int:
        """Tangent vectors that the kernel has to carry."""
        return 0

    @property
    def trace(self) -> bool:
        """Whether the kernel has to integrate the trace of the Jacobian."""
        return False

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """What it records, beside the base evidence."""
        return ()

    @property
    def outputs(self) -> tuple[Variable, ...]:
        """What of its evidence goes into the result as it is."""
        return self.evidence

    def dimensions(self, model: Model, clock: Clock) -> tuple[Dimension, ...]:
        """Return the dimensions of what it records, as far as they are its own."""
        return ()

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with its options for a model and a clock."""
        return None

    def rounded(self, model: Model, clock: Clock) -> Self:
        """Return it with defaults filled in and times as they will be used."""
        return self

    def hold(self, clock: Clock) -> int:
        """Return the step before which no cell may end early, because the measure still looks at it."""
        return 0


def unknown_state(name: str, key: str, model: Model) -> Problem | None:
    """Return the problem of an option that should name a state of the model."""
    if name in model.state_names:
        return None
    return Problem(key, f"{model.name} has no state {name}", f"it has {', '.join(model.state_names)}")


def beyond_the_end(time: float | None, key: str, clock: Clock) -> Problem | None:
    """Return the problem of a time that lies behind the end of the run."""
    end = clock.steps * clock.dt
    if time is None or time <= end * (1 + 1e-9):
        return None
    return Problem(key, f"{time:g} lies behind the end of the run", f"at most transient + duration, {end:g}")
