"""What every measure declares: its options, what it needs of the integration, and what it records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from pydantic import BaseModel, ConfigDict

from quavsweep.clock import Clock
from quavsweep.measures.variable import Dimension, Variable
from quavsweep.models import Model
from quavsweep.nearest import nearest


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
    def watched(self) -> tuple[str, ...]:
        """The states and observables whose course it follows."""
        return ()

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


def unknown_quantity(name: str, key: str, model: Model) -> Problem | None:
    """Return the problem of an option that should name a state or observable of the model."""
    known = (*model.state_names, *model.observable_names)
    if name in known:
        return None
    what, possible = "state", f"it has {', '.join(model.state_names)}"
    if model.observables:
        what, possible = "state or observable", f"{possible}; of these {', '.join(model.observable_names)}"
    return Problem(key, f"{model.name} has no {what} {name}{nearest(name, known)}", possible)


def problem_of_list(names: Sequence[str], model: Model) -> Problem | None:
    """Return the problem of the option `of` that should name some states and observables of the model."""
    if len(set(names)) < len(names):
        return Problem("of", "a quantity is given twice", "name each once")
    unknown = (unknown_quantity(name, "of", model) for name in names)
    return next((problem for problem in unknown if problem is not None), None)


def listed(dimension: str, names: Sequence[str], model: Model) -> Dimension:
    """Return the dimension that counts some states and observables, each with its unit."""
    units = tuple(model.quantity(name).unit for name in names)
    return Dimension(dimension, np.array(names, dtype=object), "state variable or observable", component_units=units)


def beyond_the_end(time: float | None, key: str, clock: Clock) -> Problem | None:
    """Return the problem of a time that lies behind the end of the run."""
    end = clock.steps * clock.dt
    if time is None or time <= end * (1 + 1e-9):
        return None
    return Problem(key, f"{time:g} lies behind the end of the run", f"at most transient + duration, {end:g}")
