"""Program: a model's equations as straight-line assignments, stored as data and interpreted over any algebra."""

from __future__ import annotations

import hashlib
import json
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from quavsweep.kernels.formula import FUNCTIONS, Arrays, on_arrays

TIME = "time"  # name of the time in a forced system
TIME_SCALE = "h"  # name of the unit of time in which the derivatives are given
Ref = str | float  # the name of a state, parameter or assignment, or the time, or a number

OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "div": operator.truediv,
    "neg": operator.neg,
    "sqrt": np.sqrt,
    "select_less": Arrays().less,  # (left, right, first, second): first where left < right, else second
    "select_less_equal": Arrays().less_equal,
    **{name: on_arrays(name) for name in FUNCTIONS},
}
SELECTS = ("select_less", "select_less_equal")


@dataclass(frozen=True)
class Assignment:
    """`target = operation(arguments)`, each target assigned once."""

    target: str
    operation: str
    arguments: tuple[Ref, ...]


@dataclass(frozen=True)
class Program:
    """The frozen mathematics of a model.

    All derivatives are given per unit of time h, a parameter of its own that is 1 unless said otherwise: a kernel
    takes h = dt times a constant of the method, so that a step multiplies nothing with dt.

    Parameters
    ----------
    states, parameters : tuple of str
        Prefixed names (`u_`, `p_`), in the model's order.
    coefficients : tuple of str
        The assignments that depend on parameters alone and that the others read: computed once per cell. In a forced
        system the last one is h itself, by which a kernel knows the times of its stages.
    assignments : tuple of Assignment
        In order; a coefficient comes before what reads it.
    rhs : tuple of Ref, length D
        The derivatives, h f_i.
    jacobian : tuple of tuples of Ref, (D, D)
        h d f_i / d u_j.
    hessian : tuple of tuples of tuples of Ref, (D, D, D)
        h d2 f_i / d u_j d u_k.
    period : Ref
        The period of the forcing, a function of the parameters; 0 if the system is autonomous. All of the above may
        depend on the time if there is one.
    """

    states: tuple[str, ...]
    parameters: tuple[str, ...]
    coefficients: tuple[str, ...]
    assignments: tuple[Assignment, ...]
    rhs: tuple[Ref, ...]
    jacobian: tuple[tuple[Ref, ...], ...]
    hessian: tuple[tuple[tuple[Ref, ...], ...], ...]
    period: Ref = 0.0

    @property
    def forced(self) -> bool:
        """Whether the derivatives depend on the time, periodically."""
        return self.period != 0.0

    @property
    def dimension(self) -> int:
        """Number of states, D."""
        return len(self.states)

    def needed(self, outputs: Iterable[Ref], given: Iterable[str] = ()) -> list[Assignment]:
        """Return the assignments that `outputs` depend on, in order, stopping at the names `given`."""
        wanted = {ref for ref in outputs if isinstance(ref, str)}
        known = set(given)
        kept = []
        for assignment in reversed(self.assignments):
            if assignment.target in wanted and assignment.target not in known:
                kept.append(assignment)
                wanted.update(ref for ref in assignment.arguments if isinstance(ref, str))
        return kept[::-1]

    @property
    def switches(self) -> tuple[tuple[Ref, Ref], ...]:
        """What the derivatives compare: where two values are equal, they may have a kink or jump."""
        needed = self.needed(self.rhs, self.coefficients)
        return tuple(dict.fromkeys((a.arguments[0], a.arguments[1]) for a in needed if a.operation in SELECTS))

    @property
    def has_constant_divergence(self) -> bool:
        """Whether the trace of the Jacobian does not depend on the state."""
        diagonal = {row[i] for i, row in enumerate(self.jacobian)}
        return {entry for entry in diagonal if isinstance(entry, str)} <= {*self.coefficients}

    def constant_divergence(self, coefficients: np.ndarray) -> np.ndarray | None:
        """Return the divergence of n cells, (n,), from their coefficients (C, n); None if it depends on the state."""
        if not self.has_constant_divergence:
            return None
        known = dict(zip(self.coefficients, coefficients, strict=True))
        values = self.evaluate([row[i] for i, row in enumerate(self.jacobian)], known)
        return np.asarray(sum(np.broadcast_to(value, coefficients.shape[1:]) for value in values))

    def evaluate(
        self,
        outputs: Sequence[Ref],
        values: Mapping[str, Any],
        operations: Mapping[str, Callable[..., Any]] = OPERATIONS,
    ) -> list[Any]:
        """Interpret the program on floats or arrays, or on anything else with its own operations.

        `values` maps names of states, parameters or coefficients to values of one kind.
        """
        known = {TIME_SCALE: 1.0, **values}
        key = (*outputs, None, *known)
        if key not in self._evaluations:
            self._evaluations[key] = self.needed(outputs, known)
        for assignment in self._evaluations[key]:
            arguments = (known[ref] if isinstance(ref, str) else ref for ref in assignment.arguments)
            known[assignment.target] = operations[assignment.operation](*arguments)
        return [known[ref] if isinstance(ref, str) else ref for ref in outputs]

    @cached_property
    def _evaluations(self) -> dict[tuple[Ref | None, ...], list[Assignment]]:
        """What evaluations so far have needed, because finding it takes longer than a few operations on arrays."""
        return {}

    def coefficient_values(self, parameters: Sequence[np.ndarray], scale: float | np.ndarray = 1.0) -> np.ndarray:
        """Return the coefficients of n cells.

        Parameters
        ----------
        parameters : sequence of (n,) arrays
            In the model's order and units.
        scale : float or (n,) float64
            The unit of time h [time unit of the model].

        Returns
        -------
        (C, n) float64
        """
        n = np.shape(parameters[0])[0] if parameters else 1
        given = dict(zip(self.parameters, parameters, strict=True))
        values = self.evaluate(self.coefficients, {**given, TIME_SCALE: scale})
        table = np.empty((len(values), n))
        for row, value in zip(table, values, strict=True):
            row[...] = value
        return table

    def forcing_periods(self, parameters: Sequence[np.ndarray]) -> np.ndarray:
        """Return the periods of the forcing of n cells, (n,) float64, from their parameters in the model's order."""
        n = np.shape(parameters[0])[0] if parameters else 1
        (value,) = self.evaluate([self.period], dict(zip(self.parameters, parameters, strict=True)))
        return np.broadcast_to(np.asarray(value, dtype=np.float64), (n,))

    def names(self, u: Iterable[Any], coefficients: Iterable[Any], t: Any = None) -> dict[str, Any]:
        """Return the environment in which state, coefficients and, in a forced system, time have these values.

        Raises
        ------
        ValueError
            If the system is forced and no time is given.
        """
        named = {**dict(zip(self.states, u, strict=True)), **dict(zip(self.coefficients, coefficients, strict=True))}
        if self.forced:
            if t is None:
                raise ValueError("a forced system has no derivatives without a time")
            named[TIME] = t
        return named

    def to_json(self) -> str:
        """Return the program as data; equal programs give equal texts."""
        return json.dumps(asdict(self), separators=(",", ":"), sort_keys=True)

    @classmethod
    def from_json(cls, text: str) -> Program:
        """Return the program that `to_json` wrote; nothing in the text is executed."""
        data = json.loads(text)
        data["assignments"] = [
            Assignment(a["target"], a["operation"], tuple(a["arguments"])) for a in data["assignments"]
        ]
        return cls(**{key: _frozen(value) for key, value in data.items()})

    @property
    def digest(self) -> str:
        """SHA-256 of the mathematics."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()


def _frozen(value: Any) -> Any:
    return tuple(_frozen(item) for item in value) if isinstance(value, list) else value
