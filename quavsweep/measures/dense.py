"""The measures that look at every step: orbit, samples, peak, first_time."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import BaseModel, Field, model_validator

from quavsweep.clock import Clock
from quavsweep.measures.lyapunov import counted
from quavsweep.measures.measure import Measure, Problem, beyond_the_end, listed, problem_of_list, unknown_quantity
from quavsweep.measures.variable import Dimension, Variable
from quavsweep.models import Model

MAX_TIMES = 10**7  # states of an orbit, per cell
MAX_SAMPLES = 10**6  # per cell


class DenseMeasure(Measure):
    """A measure that needs the state after every step."""

    dense: ClassVar[bool] = True


class Orbit(DenseMeasure):
    """The state at even times; no cell ends before them."""

    every: float = Field(gt=0, description="time between two stored states, in the model's time")
    after: float = Field(default=0.0, ge=0, description="time of the first of them")
    until: float | None = Field(default=None, gt=0, description="time of the last of them; default the end of the run")

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """The states."""
        return (Variable("orbit", ("time", "state"), "float64", "state", "state at the times"),)

    def steps(self, clock: Clock) -> range:
        """Return the steps after which the state is stored."""
        last = last_step(self.until, clock)
        return range(clock.steps_of(self.after), last + 1, clock.steps_of(self.every) or 1)

    def dimensions(self, model: Model, clock: Clock) -> tuple[Dimension, ...]:
        """Return the times."""
        times = np.asarray(self.steps(clock)) * clock.dt
        return (Dimension("time", times, "time from the initial state", model.time_unit),)

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with its times."""
        until = self.until if self.until is not None else clock.steps * clock.dt
        if beyond := beyond_the_end(self.until, "until", clock) or beyond_the_end(self.every, "every", clock):
            return beyond
        if self.after > until:
            return Problem("after", f"{self.after:g} lies behind the last time, {until:g}", "a smaller one")
        if (until - self.after) / self.every > MAX_TIMES:
            return Problem("every", f"{self.every:g} gives more than {MAX_TIMES} states per cell", "a larger one")
        return None

    def rounded(self, model: Model, clock: Clock) -> Self:
        """Return it with whole steps."""
        stride = max(1, clock.steps_of(self.every)) * clock.dt
        until = rounded_end(self.until, clock)
        return self.model_copy(update={"every": stride, "after": clock.steps_of(self.after) * clock.dt, "until": until})

    def hold(self, clock: Clock) -> int:
        """Return the step of the last state."""
        steps = self.steps(clock)
        return steps[-1] if steps else 0


class Section(BaseModel):
    """A surface in the space of states: one state or observable has a fixed value."""

    model_config = Measure.model_config

    of: str = Field(description="the state or observable")
    at: float = Field(default=0.0, description="its value there, in its unit")
    direction: Literal["up", "down", "both"] = Field(default="up", description="which crossings count")


class Samples(DenseMeasure):
    """States on a section, at maxima of a quantity, or at even times, once the transient is over."""

    section: Section | None = Field(default=None, description="sample the crossings of this plane")
    maxima: str | None = Field(
        default=None, description="sample the maxima of this state or observable; default the first state"
    )
    every: float | None = Field(default=None, gt=0, description="sample at multiples of this time, in the model's time")
    max: int = Field(default=400, ge=1, le=MAX_SAMPLES, description="samples kept per cell, the first ones")

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        given = [key for key in ("section", "maxima", "every") if getattr(self, key) is not None]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} exclude each other; keep one")
        return self

    @property
    def watched(self) -> tuple[str, ...]:
        """What has a section or maxima."""
        named = (self.maxima, self.section.of if self.section else None)
        return tuple(name for name in named if name is not None)

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """The states, their times and how many there were."""
        return (
            Variable("samples", ("sample", "state"), "float64", "state", "states on the section, in order"),
            Variable("sample_time", ("sample",), "float64", "time", "times of the samples, from t = 0"),
            Variable("sample_count", (), "int32", "1", "samples found, kept or not"),
        )

    def dimensions(self, model: Model, clock: Clock) -> tuple[Dimension, ...]:
        """Return the number of the sample."""
        return (counted("sample", self.max, "number of the sample"),)

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with the section."""
        if self.section is not None:
            return unknown_quantity(self.section.of, "section.of", model)
        if self.maxima is not None:
            return unknown_quantity(self.maxima, "maxima", model)
        return beyond_the_end(self.every, "every", clock)

    def rounded(self, model: Model, clock: Clock) -> Self:
        """Return it with whole steps, and with the default section written out."""
        if self.every is not None:
            return self.model_copy(update={"every": max(1, clock.steps_of(self.every)) * clock.dt})
        if self.section is None and self.maxima is None:
            return self.model_copy(update={"maxima": model.state_names[0]})
        return self


class Peak(DenseMeasure):
    """The largest magnitude of some quantities, with its sign and time; no cell ends before `until`."""

    of: list[str] = Field(min_length=1, description="the states and observables")
    until: float | None = Field(default=None, gt=0, description="from t = 0 until then; default the end of the run")

    @property
    def watched(self) -> tuple[str, ...]:
        """The states and observables."""
        return tuple(self.of)

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """The values and their times."""
        return (
            Variable("peak", ("peak_of",), "float64", "state", "value of largest magnitude, with its sign"),
            Variable("peak_time", ("peak_of",), "float64", "time", "time of the peak, from t = 0"),
        )

    def dimensions(self, model: Model, clock: Clock) -> tuple[Dimension, ...]:
        """Return the quantities."""
        return (listed("peak_of", self.of, model),)

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with quantities or time."""
        return problem_of_list(self.of, model) or beyond_the_end(self.until, "until", clock)

    def rounded(self, model: Model, clock: Clock) -> Self:
        """Return it with whole steps."""
        return self.model_copy(update={"until": rounded_end(self.until, clock)})

    def hold(self, clock: Clock) -> int:
        """Return the last step that it looks at."""
        return last_step(self.until, clock)


class FirstTime(DenseMeasure):
    """When a quantity is first above, or below, a value; no cell ends before `until`."""

    of: str = Field(description="the state or observable")
    above: float | None = Field(default=None, description="the value to exceed, in its unit")
    below: float | None = Field(default=None, description="or the value to fall below")
    until: float | None = Field(default=None, gt=0, description="from t = 0 until then; default the end of the run")

    @model_validator(mode="after")
    def _one_limit(self) -> Self:
        if (self.above is None) == (self.below is None):
            raise ValueError("give either above or below")
        return self

    @property
    def limit(self) -> tuple[float, str]:
        """The value, and the direction in which it is crossed."""
        return (self.above, "up") if self.above is not None else (self.below or 0.0, "down")

    @property
    def watched(self) -> tuple[str, ...]:
        """The state or observable."""
        return (self.of,)

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """The time, NaN where it does not happen."""
        return (Variable("first_time", (), "float64", "time", "first time beyond the limit, from t = 0; NaN if never"),)

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with state or time."""
        return unknown_quantity(self.of, "of", model) or beyond_the_end(self.until, "until", clock)

    def rounded(self, model: Model, clock: Clock) -> Self:
        """Return it with whole steps."""
        return self.model_copy(update={"until": rounded_end(self.until, clock)})

    def hold(self, clock: Clock) -> int:
        """Return the last step that it looks at."""
        return last_step(self.until, clock)


class LastTime(DenseMeasure):
    """When a quantity last has a value, in either direction, before the integration ends."""

    of: str = Field(description="the state or observable")
    at: float = Field(default=0.0, description="the value, in its unit")

    @property
    def watched(self) -> tuple[str, ...]:
        """The state or observable."""
        return (self.of,)

    @property
    def evidence(self) -> tuple[Variable, ...]:
        """The time, NaN where it does not happen."""
        return (Variable("last_time", (), "float64", "time", "last time at the value, from t = 0; NaN if never"),)

    def problem(self, model: Model, clock: Clock) -> Problem | None:
        """Return what is wrong with the state."""
        return unknown_quantity(self.of, "of", model)


def rounded_end(until: float | None, clock: Clock) -> float | None:
    """Return the time until which a measure looks in whole steps; None, the end of the run, stays open."""
    return None if until is None else last_step(until, clock) * clock.dt


def last_step(until: float | None, clock: Clock) -> int:
    """Return the last step of a measure that looks until some time."""
    return clock.steps if until is None else max(1, clock.steps_of(until))
