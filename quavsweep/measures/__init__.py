"""What is recorded per cell: declared schemas. Base evidence first, then the measures that a config may ask for."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from quavsweep.clock import Clock
from quavsweep.measures.dense import FirstTime, LastTime, Orbit, Peak, Samples, Section
from quavsweep.measures.lyapunov import Lyapunov, counted
from quavsweep.measures.measure import Measure, Problem
from quavsweep.measures.statistics import Statistics
from quavsweep.measures.variable import BASE, REGION_VARIABLE, STATUS_VARIABLE, Dimension, Evidence, Variable
from quavsweep.measures.verdict import Verdict
from quavsweep.models import Model

__all__ = [
    "BASE",
    "REGION_VARIABLE",
    "STATUS_VARIABLE",
    "Dimension",
    "Evidence",
    "FirstTime",
    "LastTime",
    "Lyapunov",
    "Measure",
    "Measures",
    "Orbit",
    "Peak",
    "Problem",
    "Samples",
    "Section",
    "Statistics",
    "Variable",
    "Verdict",
]

BLOCK = 1  # steps per block where there is nothing to orthonormalise


class Measures(BaseModel):
    """The measures of a sweep."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, defer_build=True)

    lyapunov: Lyapunov | None = Field(default=None, description="Lyapunov exponents with error bars")
    orbit: Orbit | None = Field(default=None, description="the state at even times")
    samples: Samples | None = Field(default=None, description="states on a section, at maxima, or at even times")
    peak: Peak | None = Field(default=None, description="the largest magnitude of some states or observables")
    first_time: FirstTime | None = Field(default=None, description="when a quantity first exceeds a value")
    last_time: LastTime | None = Field(default=None, description="when a quantity last has a value")
    statistics: Statistics | None = Field(default=None, description="mean, extremes, changes of sign of quantities")
    verdict: Verdict | None = Field(default=None, description="one tangent vector beyond the end, without lyapunov")

    @model_validator(mode="before")
    @classmethod
    def _named_is_meant(cls, data: Any) -> Any:
        """Read a measure that is named without options as one with the defaults."""
        return {k: {} if v is None else v for k, v in data.items()} if isinstance(data, dict) else data

    @property
    def chosen(self) -> dict[str, Measure]:
        """The measures asked for, by name."""
        named = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: measure for name, measure in named.items() if measure is not None}

    @property
    def vectors(self) -> int:
        """Tangent vectors that the kernel has to carry, K."""
        return max((measure.vectors for measure in self.chosen.values()), default=0)

    @property
    def trace(self) -> bool:
        """Whether the kernel has to integrate the trace of the Jacobian."""
        return any(measure.trace for measure in self.chosen.values())

    @property
    def dense(self) -> bool:
        """Whether some measure must see the state after every step."""
        return any(measure.dense for measure in self.chosen.values())

    @property
    def watched(self) -> tuple[str, ...]:
        """The states and observables that some measure looks at."""
        return tuple(name for measure in self.chosen.values() for name in measure.watched)

    @property
    def block(self) -> int:
        """Steps between two orthonormalisations."""
        if self.lyapunov:
            return self.lyapunov.block
        return Lyapunov().block if self.verdict else BLOCK

    @property
    def batch(self) -> float | None:
        """The length of a batch that is asked for."""
        return self.lyapunov.batch if self.lyapunov else None

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """All that a shard records per cell."""
        return (*BASE, *(variable for measure in self.chosen.values() for variable in measure.evidence))

    @property
    def outputs(self) -> tuple[Variable, ...]:
        """What goes from the evidence into the result as it is."""
        return tuple(variable for measure in self.chosen.values() for variable in measure.outputs)

    def dimensions(self, model: Model, clock: Clock) -> dict[str, Dimension]:
        """Return the dimensions of evidence and result beyond the cell, by name."""
        names = np.array(model.state_names, dtype=object)
        units = tuple(state.unit for state in model.states)
        own = (d for measure in self.chosen.values() for d in measure.dimensions(model, clock))
        dimensions = (
            Dimension("state", names, "state variable", component_units=units),
            counted("eigenvalue", len(names), "number of the eigenvalue, largest real part first"),
            *own,
        )
        return {dimension.name: dimension for dimension in dimensions}

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return the first thing that is wrong with the options of a measure; its key begins with the measure's."""
        for name, measure in self.chosen.items():
            found = measure.problem(model, clock)
            if found is not None:
                return Problem(f"{name}.{found.key}", found.what, found.possible)
        return None

    def rounded(self, model: Model, clock: Clock) -> Measures:
        """Return them with defaults filled in and times as they will be used."""
        return self.model_copy(update={name: measure.rounded(model, clock) for name, measure in self.chosen.items()})

    def changes(self, used: Measures) -> tuple[str, ...]:
        """Return a sentence for each time that had to be changed."""
        return tuple(
            f"measures.{name}.{key} is rounded to whole steps: {asked:g} -> {new:g}"
            for name, measure in self.chosen.items()
            for key, asked in measure
            if isinstance(asked, float)
            and isinstance(new := getattr(used.chosen[name], key), float)
            and abs(new - asked) > 1e-9 * abs(asked)
        )

    def hold(self, clock: Clock) -> int:
        """Return the step before which no cell may end early."""
        return max((measure.hold(clock) for measure in self.chosen.values()), default=0)
