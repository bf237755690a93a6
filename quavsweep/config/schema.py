"""What a config may say: its keys, their types, ranges and meanings."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, field_validator

from quavsweep.measures import Measures

MAX_AXIS = 10**6
ENSEMBLE = "ensemble"  # the name of the axis that counts starts
AXIS_TAG, ENSEMBLE_TAG = "[axis]", "[ensemble]"  # pydantic puts them into its paths; no key looks so
LIST_TAG, VALUES_TAG = "[list]", "[values]"
TAGS = frozenset([AXIS_TAG, ENSEMBLE_TAG, LIST_TAG, VALUES_TAG])

_STRICT = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)
Interval = Annotated[list[float], Field(min_length=2, max_length=2)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$")]


class ValuesSection(BaseModel):
    """Values of a quantity: evenly (or logarithmically) spaced ones, or a list."""

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
        """Return the values."""
        spaced = np.geomspace if self.spacing == "log" else np.linspace
        return tuple(float(value) for value in (self.values or spaced(*self.ends or (0.0, 0.0, 0))))

    @property
    def length(self) -> int:
        """The number of values, known before they are."""
        return self.num or len(self.values or ())


def _kind_of_values(value: Any) -> str:
    """Return the tag of what gives the values of a zipped quantity."""
    return LIST_TAG if isinstance(value, list) else VALUES_TAG


Values = Annotated[list[float], Field(min_length=1, max_length=MAX_AXIS)]
AnyValues = Annotated[
    Annotated[Values, Tag(LIST_TAG)] | Annotated[ValuesSection, Tag(VALUES_TAG)], Discriminator(_kind_of_values)
]


class AxisSection(ValuesSection):
    """One axis: the values of a quantity, or of several that vary together."""

    zip: dict[str, AnyValues] | None = Field(
        default=None, description="quantities that vary together along it, equally many values of each"
    )

    @property
    def zipped(self) -> dict[str, ValuesSection]:
        """The quantities that vary together, each with its values; a list is a section too."""
        return {
            name: ValuesSection(values=values) if isinstance(values, list) else values
            for name, values in (self.zip or {}).items()
        }

    @property
    def length(self) -> int:
        """The number of values, known before they are."""
        return next((section.length for section in self.zipped.values()), super().length)


class EnsembleSection(BaseModel):
    """Starts that are drawn at random from a box, the same ones in every cell of the other axes."""

    model_config = _STRICT

    num: int = Field(ge=1, le=MAX_AXIS, description="number of starts")
    seed: int = Field(default=1, ge=0, lt=2**63, description="which starts are drawn")
    box: dict[str, Interval] = Field(description="states that are drawn, each evenly from its interval [low, high]")


class Draws(dict[str, Any]):
    """What stands under `axes.ensemble`, told apart from other axes by its key alone."""


def _kind_of_axis(value: Any) -> str:
    """Return the tag of what stands under a key of `axes`."""
    return ENSEMBLE_TAG if isinstance(value, Draws | EnsembleSection) else AXIS_TAG


AnyAxis = Annotated[
    Annotated[AxisSection, Tag(AXIS_TAG)] | Annotated[EnsembleSection, Tag(ENSEMBLE_TAG)],
    Discriminator(_kind_of_axis),
]


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
        default=2.0, ge=0, description="nor is one beyond so often the departure of ln growth from its line, over time"
    )
    digits: float = Field(
        default=1.5, ge=0, description="weighted averages along a regular orbit agree to so many digits"
    )


class Effort(BaseModel):
    """How much further cells go on whose end is not known."""

    model_config = _STRICT

    max_duration: float = Field(gt=0, description="time over which their exponents are averaged, at most")
    of: list[Literal["undecided", "chaos"]] = Field(
        default=["undecided"], min_length=1, max_length=2, description="the regions whose cells go on"
    )

    @field_validator("of")
    @classmethod
    def _in_order(cls, of: list[str]) -> list[str]:
        """Give each region once, in one order, whatever the text says."""
        return [region for region in ("undecided", "chaos") if region in of]


class Config(BaseModel):
    """A sweep as the user writes it."""

    model_config = _STRICT

    name: Name = Field(description="letters, digits, . _ -; at most 100, the first a letter or digit")
    model: str = Field(description="a model of the catalogue")
    parameters: dict[str, float] = Field(default_factory=dict, description="what differs from the model's defaults")
    initial: dict[str, float] = Field(default_factory=dict, description="initial state")
    axes: dict[str, AnyAxis] = Field(default_factory=dict, description="what varies, the last axis fastest")
    integrate: IntegrateSection
    measures: Measures = Field(default_factory=Measures, description="what is recorded")
    stop_early: bool = Field(default=True, description="end a cell once its end is certified")
    effort: Effort | None = Field(default=None, description="more time for cells whose end is not known")
    evidence: Literal["full", "summary"] = Field(
        default="full",
        description="what shards hold of a cell: all that is recorded, or only what goes into the result",
    )
    classify: Thresholds = Field(default_factory=Thresholds, description="thresholds of the classification")
    plot: list[str] = Field(default_factory=list, description="what the figure of a run shows, as plot --variable")

    @field_validator("axes", mode="before")
    @classmethod
    def _tell_ensemble(cls, axes: Any) -> Any:
        """Mark the mapping under `ensemble`, so that it is read as one."""
        if not isinstance(axes, dict) or isinstance(axes.get(ENSEMBLE), EnsembleSection):
            return axes
        draws = axes.get(ENSEMBLE)
        return {**axes, ENSEMBLE: Draws(draws) if isinstance(draws, dict) else draws} if ENSEMBLE in axes else axes

    @property
    def ensemble(self) -> EnsembleSection | None:
        """The axis of drawn starts, if there is one."""
        section = self.axes.get(ENSEMBLE)
        return section if isinstance(section, EnsembleSection) else None

    @property
    def zipped(self) -> dict[str, AxisSection]:
        """The axes along which several quantities vary together, by name."""
        return {
            name: section
            for name, section in self.axes.items()
            if isinstance(section, AxisSection) and section.zip is not None
        }

    @property
    def varied(self) -> dict[str, tuple[str, ...]]:
        """The key that makes each varied parameter or state vary, by its name."""
        keys: dict[str, tuple[str, ...]] = {n: ("axes", n) for n in self.axes if n not in (ENSEMBLE, *self.zipped)}
        keys |= {q: ("axes", axis, "zip", q) for axis, section in self.zipped.items() for q in section.zip or {}}
        return keys | {n: ("axes", ENSEMBLE, "box", n) for n in (self.ensemble.box if self.ensemble else ())}
