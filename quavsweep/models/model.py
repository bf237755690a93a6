"""What a model is: named states, named parameters, and equations written once as a plain function."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from quavsweep.errors import ModelError
from quavsweep.models.mistake import place
from quavsweep.models.quantity import Observable, Parameter, State, make_float

NAME = r"[A-Za-z][A-Za-z0-9_]{0,63}"  # of a state or parameter

# Names that the result's own variables and dimensions carry.
RESERVED = frozenset(
    [
        *("region", "status", "period", "exponent", "state", "cell", "ensemble", "time", "batch", "segment"),
        *("lyapunov", "lyapunov_raw", "lyapunov_se", "lyapunov_chaotic", "lyapunov_chaotic_se", "was_chaotic"),
        *("settle_time", "time_used", "final_state", "equilibrium", "eigenvalue", "eigenvalue_re", "eigenvalue_im"),
        *("cycle_hits", "attractor", "sum_error", "zero_error", "orbit", "sample", "samples", "sample_time"),
        *("sample_count", "peak", "peak_of", "peak_time", "first_time", "last_time", "t"),
        *("attractor_number", "attractor_kind", "attractor_point", "attractor_exponents", "attractor_share"),
        *("attractor_share_se", "kind", "starts", "basin_share", "basin_share_se", "lifetime", "lifetime_se"),
        *("lifetime_after", "lifetime_p", "lifetime_at_least", "chaotic_share", "chaotic_share_se"),
        *("growth_departure", "birkhoff_digits", "chaotic_until", "cycle_symmetry", "cycle_point"),
        *("multiplier_re", "multiplier_im", "statistic_of", "statistic_sum", "statistic_mean", "statistic_mean_se"),
        *("statistic_min", "statistic_max", "sign_changes"),
    ]
)


@dataclass(frozen=True)
class Relation:
    """A relation that a physical system obeys; breaking it is a warning, not an error."""

    text: str
    holds: Callable[..., Any]
    meaning: str = ""

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names of the parameters that the relation speaks of."""
        return tuple(inspect.signature(self.holds).parameters)


@dataclass(frozen=True)
class Section:
    """A Poincaré section: where a state crosses a value, or has a maximum where none is given."""

    of: str
    at: float | None = None
    direction: str = "up"

    def __post_init__(self) -> None:
        if self.at is not None:
            make_float(self, "at")


@dataclass(frozen=True)
class Example:
    """A first sweep of a model, for `quavsweep init`.

    Parameters
    ----------
    initial : mapping
        Initial state.
    axes : mapping
        From a name to first value, last value and number of values.
    dt, transient, duration : float
        In the model's time.
    block : int
        Steps between two orthonormalisations.
    exponents : int, optional
        Lyapunov exponents that are worth their time; default all, none if it is 0.
    """

    initial: Mapping[str, float]
    axes: Mapping[str, tuple[float, float, int]]
    dt: float
    transient: float
    duration: float
    block: int = 25
    exponents: int | None = None


@dataclass(frozen=True)
class Model:
    """A system of ordinary differential equations.

    Parameters
    ----------
    name : str
        The name in configs.
    rhs : callable
        `rhs(state..., parameter...)` by name, returns the derivatives in the order of `states`. It is called
        with floats by tests and once with symbols to derive the program, so it must not branch on its arguments;
        `quavsweep.models.function` has functions and choices that take both.
    states, parameters : tuple
        What `rhs` takes, in order.
    relations : tuple of Relation
        Warnings for values that no physical system has.
    symmetries : tuple of tuples of int
        Sign patterns (one sign per state) under which the equations are equivariant.
    section : Section, optional
        Where cycles are looked for; default the maxima of the first state.
    forcing_period : callable, optional
        The period of a forced system as a function of parameters by name; `rhs` then takes `t` before the states.
    bound : float
        A state with a component beyond it counts as diverged, in the states' units.
    time_unit : str
        Unit of time, `1` where the equations are dimensionless.
    source : str
        Where the equations come from, with equation numbers.
    example : Example, optional
        A first sweep.
    observables : tuple of Observable
        What else of the system measures and figures can show.

    Raises
    ------
    ModelError
        If the function's arguments are not the states and parameters, or a name is not usable.
    """

    name: str
    rhs: Callable[..., Sequence[Any]]
    states: tuple[State, ...]
    parameters: tuple[Parameter, ...]
    relations: tuple[Relation, ...] = ()
    symmetries: tuple[tuple[int, ...], ...] = ()
    section: Section | None = None
    forcing_period: Callable[..., Any] | None = None
    bound: float = 1e6
    time_unit: str = "1"
    source: str = ""
    example: Example | None = None
    observables: tuple[Observable, ...] = ()

    def __post_init__(self) -> None:
        make_float(self, "bound")
        self._check_names()
        self._check_parts()
        self._check_functions()

    def _check_names(self) -> None:
        """Refuse names that are not usable."""
        if not re.fullmatch(NAME, self.name):
            raise ModelError(f"{self.name!r} cannot be the name of a model", possible="letters, digits and _")
        names = [*self.state_names, *self.parameter_names, *self.observable_names]
        for name in names:
            if not re.fullmatch(NAME, name) or name in RESERVED or names.count(name) > 1:
                raise ModelError(f"the name {name} is taken, repeated or not a plain identifier", self.name)
        if not self.states:
            raise ModelError("a model needs a state", self.name, "states=(State('x'), ...)")

    def _check_parts(self) -> None:
        """Refuse symmetries, a section, a bound or turns that do not fit the states."""
        count = len(self.states)
        for signs in self.symmetries:
            if len(signs) != count or not {*signs} <= {-1, 1}:
                raise ModelError(f"the symmetry {signs} is not {count} signs", self.name, "1 or -1 for each state")
        if self.section is not None and self.section.of not in self.state_names:
            what = f"the section is of {self.section.of}, which is no state"
            raise ModelError(what, self.name, f"the states are {', '.join(self.state_names)}")
        if self.section is not None and self.section.direction not in ("up", "down", "both"):
            raise ModelError(f"the section's direction is {self.section.direction}", self.name, "up, down or both")
        for parameter in self.parameters:
            if not parameter.admits(parameter.default) or not math.isfinite(parameter.default):
                what = f"the default {parameter.default:g} of {parameter.name} is not possible"
                raise ModelError(what, self.name, f"it must be {parameter.domain or 'finite'}")
        if not self.bound > 0 or not all(0 <= state.circle < math.inf for state in self.states):
            raise ModelError("the bound and the circles of states are lengths", self.name, "numbers above 0")
        for state in self.states:
            if not state.low < state.high:
                what = f"no value of {state.name} lies between {state.low:g} and {state.high:g}"
                raise ModelError(what, self.name, "low < high")

    def _check_functions(self) -> None:
        """Refuse functions whose arguments are not the model's names."""
        forced = self.forcing_period is not None
        for name, function in (("rhs", self.rhs), ("forcing_period", self.forcing_period)):
            if not callable(function) and (name == "rhs" or forced):
                raise ModelError(f"{name} is {function!r}, which is no function", self.name, f"{name}=lambda ...: ...")
        names = [*(["t"] if forced else []), *self.state_names, *self.parameter_names]
        arguments = list(inspect.signature(self.rhs).parameters)
        if arguments != names:
            where = place(self.rhs) if self.rhs.__name__ != "<lambda>" else self.name
            taken, declared = ", ".join(arguments) or "nothing", ", ".join(names)
            if forced and arguments == names[1:]:
                raise ModelError("the system is forced, so its equations take t first", where, f"take {declared}")
            if not forced and arguments == ["t", *names]:
                what = "the equations take t, but the model declares no forcing_period"
                raise ModelError(what, where, "only periodic forcing is known: forcing_period=lambda omega: ...")
            raise ModelError(f"the equations take {taken} but the model declares {declared}", where)
        if self.forcing_period is not None:
            for name in self.forcing_arguments:
                if name not in self.parameter_names:
                    what = f"forcing_period takes {name}, which is no parameter"
                    raise ModelError(what, place(self.forcing_period), f"there are {', '.join(self.parameter_names)}")

        self._check_observables(names)

    def _check_observables(self, names: Sequence[str]) -> None:
        """Refuse observables that are no functions of the model's names."""
        for observable in self.observables:
            if not callable(observable.function):
                what = f"{observable.name} is {observable.function!r}, which is no function"
                raise ModelError(what, self.name, f"Observable('{observable.name}', lambda ...: ...)")
            for name in observable.arguments:
                if name not in names:
                    what = f"{observable.name} takes {name}, which the model does not declare"
                    raise ModelError(what, place(observable.function), f"there are {', '.join(names)}")

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        return tuple(state.name for state in self.states)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return tuple(parameter.name for parameter in self.parameters)

    @property
    def observable_names(self) -> tuple[str, ...]:
        """Names of the observables, in order."""
        return tuple(observable.name for observable in self.observables)

    @property
    def limited(self) -> bool:
        """Whether orbits can leave the domain of the equations."""
        return any(state.limited for state in self.states)

    @property
    def defaults(self) -> dict[str, float]:
        """The parameters' default values by name."""
        return {parameter.name: parameter.default for parameter in self.parameters}

    def field(self, u: Sequence[Any], p: Sequence[Any], t: Any = 0.0) -> Sequence[Any]:
        """Return the derivatives, whether the equations take the time or not; u and p in the model's order."""
        return self.rhs(*([] if self.forcing_period is None else [t]), *u, *p)

    def forcing(self, parameters: Mapping[str, Any]) -> Any:
        """Return the period of the forcing for parameters by name; None if the system is autonomous."""
        if self.forcing_period is None:
            return None
        return self.forcing_period(**{name: parameters[name] for name in self.forcing_arguments})

    @property
    def forcing_arguments(self) -> tuple[str, ...]:
        """Names of the parameters that the period of the forcing depends on."""
        return tuple(inspect.signature(self.forcing_period).parameters) if self.forcing_period else ()

    @property
    def circles(self) -> tuple[tuple[int, float], ...]:
        """Index and length of a turn of the states that are angles."""
        return tuple((i, state.circle) for i, state in enumerate(self.states) if state.circle)

    def wrap(self, u: np.ndarray) -> np.ndarray:
        """Return states (n, D) with angles within their first turn, 0 <= angle < turn."""
        if not self.circles:
            return u
        u = u.copy()
        for i, turn in self.circles:
            angle = np.mod(u[:, i], turn)
            u[:, i] = np.where(angle == turn, 0.0, angle)  # what lies just below 0 is rounded to a whole turn
        return u

    def difference(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return u - v, states (n, D), angles by the shorter way round."""
        apart: np.ndarray = np.subtract(u, v)
        for i, turn in self.circles:
            apart[:, i] -= turn * np.rint(apart[:, i] / turn)
        return apart

    def bounded(self, u: np.ndarray) -> np.ndarray:
        """Return which states (n, D) are numbers within the bound, (n,) bool; angles have none."""
        size = np.abs(u)
        for i, _ in self.circles:
            size[:, i] = np.where(np.isfinite(size[:, i]), 0.0, size[:, i])
        return np.asarray((self.bound >= size.T).all(axis=0))

    def inside(self, u: np.ndarray) -> np.ndarray:
        """Return which states (D, ...) lie in the domain of the equations, (...) bool; those that are NaN do not."""
        limited = [state.admits(u[i]) for i, state in enumerate(self.states) if state.limited]
        return np.logical_and.reduce(limited) if limited else np.ones(u.shape[1:], dtype=bool)

    def quantity(self, name: str) -> State | Parameter | Observable:
        """Return the state, parameter or observable of that name.

        Raises
        ------
        KeyError
            If there is none.
        """
        quantities: list[State | Parameter | Observable] = [*self.states, *self.parameters, *self.observables]
        return {item.name: item for item in quantities}[name]
