"""The quantities of a model: state variables, parameters, and observables that follow from them."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


def make_float(owner: Any, *names: str) -> None:
    """Turn numbers of a frozen class into floats, so that 1 and 1.0 make the same model."""
    for name in names:
        object.__setattr__(owner, name, float(getattr(owner, name)))


def _interval(above: str, low: float, below: str, high: float) -> str:
    """Return an interval in words, an end that is infinite left out."""
    ends = (f"{sign} {end:.10g}" for sign, end in ((above, low), (below, high)) if math.isfinite(end))
    return " and ".join(ends)


@dataclass(frozen=True)
class State:
    """A state variable: its ASCII name, its unit, and its symbol in figures (LaTeX without dollars).

    `circle` is the length of a turn where the variable is an angle that wraps, 0 where it is not. The equations make
    sense in the open interval from `low` to `high`; an orbit that comes to its ends has left the domain.
    """

    name: str
    unit: str = "1"
    symbol: str = ""
    meaning: str = ""
    circle: float = 0.0
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        make_float(self, "circle", "low", "high")

    @property
    def limited(self) -> bool:
        """Whether the equations make sense in a part of its values only."""
        return self.low > -math.inf or self.high < math.inf

    @property
    def domain(self) -> str:
        """The domain in words, empty if there is none."""
        return _interval(">", self.low, "<", self.high)

    def admits(self, value: Any) -> Any:
        """Whether a value, or each value of an array, lies in the domain; NaN does not."""
        return (value > self.low) & (value < self.high)


@dataclass(frozen=True)
class Parameter:
    """A parameter: default value, unit, meaning, and the domain in which the equations make sense.

    The domain is an interval; `open_low` says whether its lower end is excluded.
    """

    name: str
    default: float
    unit: str = "1"
    symbol: str = ""
    meaning: str = ""
    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False

    def __post_init__(self) -> None:
        make_float(self, "default", "low", "high")

    @property
    def domain(self) -> str:
        """The domain in words, empty if there is none."""
        return _interval(">" if self.open_low else ">=", self.low, "<=", self.high)

    def admits(self, value: Any) -> Any:
        """Whether a value, or each value of an array, lies in the domain."""
        above = value > self.low if self.open_low else value >= self.low
        return above & (value <= self.high)


@dataclass(frozen=True)
class Observable:
    """A quantity that states and parameters give, such as an energy or a force.

    Parameters
    ----------
    name : str
        As measures and figures call it.
    function : callable
        Takes those states and parameters by name that it needs, and `t` if the system is forced; under the rules of
        the model's `rhs`, which it may call.
    unit, symbol, meaning : str
    component : int, optional
        Which component it is of what the function returns, where that is a vector.
    """

    name: str
    function: Callable[..., Any]
    unit: str = "1"
    symbol: str = ""
    meaning: str = ""
    component: int | None = None

    @property
    def arguments(self) -> tuple[str, ...]:
        """The names of what the function takes."""
        return tuple(inspect.signature(self.function).parameters)

    def value(self, known: Mapping[str, Any]) -> Any:
        """Return its value where states, parameters and time have these values by name."""
        value = self.function(**{name: known[name] for name in self.arguments})
        return value if self.component is None else value[self.component]


def vector(
    name: str, function: Callable[..., Any], unit: str, symbol: str, meaning: str, axes: str = "xyz"
) -> tuple[Observable, ...]:
    """Return the components of a vector as observables; `{}` in its name and symbol stands for the axis."""
    return tuple(
        Observable(name.format(axis), function, unit, symbol.format(axis), f"{meaning}, {axis}", i)
        for i, axis in enumerate(axes)
    )
