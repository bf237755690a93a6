"""What a config may say: its keys, their types, ranges and meanings."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from quavsweep.measures import Measures

MAX_AXIS = 10**6

_STRICT = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$")]


class AxisSection(BaseModel):
    """One axis: evenly (or logarithmically) spaced values, or a list."""

    model_config = _STRICT

    start: float | None = Field(default=None, description="first value")
    stop: float | None = Field(default=None, description="last value")
    num: int | None = Field(default=None, ge=1, le=MAX_AXIS, description="number of values")
    spacing: Literal["linear", "log"] = Field(default="linear", description="how the values are spaced")
    values: list[float] | None = Field(
        default=None, min_length=1, max_length=MAX_AXIS, description="the values themselves"
    )

    @property
    def ends(self) -> tuple[float, float, int] | None:
        """Start, stop and number of values, unless one of them is missing."""
        if self.start is None or self.stop is None or self.num is None:
            return None
        return self.start, self.stop, self.num

    def points(self) -> tuple[float, ...]:
        """Return the values of the axis."""
        spaced = np.geomspace if self.spacing == "log" else np.linspace
        return tuple(float(value) for value in (self.values or spaced(*self.ends or (0.0, 0.0, 0))))


class IntegrateSection(BaseModel):
    """How the equations are integrated; times in the model's unit."""

    model_config = _STRICT

    method: Literal["rk4", "dp8"] = Field(default="rk4", description="Runge-Kutta method, of order 4 or 8")
    dt: float = Field(gt=0, description="step")
    transient: float = Field(default=0.0, ge=0, description="time before exponents are averaged")
    duration: float = Field(gt=0, description="time over which they are averaged")
    segment: float | None = Field(default=None, gt=0, description="stretch between two looks at a cell")
    tolerance: float = Field(
        default=1e-2, gt=0, description="error of a state, against its magnitude, beyond which the step is warned of"
    )


class Thresholds(BaseModel):
    """Thresholds of the classification; changing them needs no new integration."""

    model_config = _STRICT

    errors: float = Field(default=3.0, gt=0, description="an exponent beyond so many standard errors is not zero")
    neutral: float = Field(
        default=3.0, ge=0, description="nor is one beyond so often the departure of ln growth from its line, over time"
    )
    digits: float = Field(
        default=1.5, ge=0, description="weighted averages along a regular orbit agree to so many digits"
    )


class Config(BaseModel):
    """A sweep as the user writes it."""

    model_config = _STRICT

    name: Name = Field(description="letters, digits, . _ -; at most 100, the first a letter or digit")
    model: str = Field(description="a model of the catalogue")
    parameters: dict[str, float] = Field(default_factory=dict, description="what differs from the model's defaults")
    initial: dict[str, float] = Field(default_factory=dict, description="initial state")
    axes: dict[str, AxisSection] = Field(default_factory=dict, description="what varies, the last axis fastest")
    integrate: IntegrateSection
    measures: Measures = Field(default_factory=Measures, description="what is recorded")
    stop_early: bool = Field(default=True, description="end a cell once its end is certified")
    classify: Thresholds = Field(default_factory=Thresholds, description="thresholds of the classification")
