"""Lowering: a program's functions are spelt out as arithmetic and bits, shared where they are equal."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

from quavsweep.kernels.formula import FUNCTIONS
from quavsweep.kernels.program import Assignment, Program, Ref

# Operations on whole numbers, which only lowered programs have, besides `bits`, `real` and `select_equal`.
WHOLE = {"and": "&", "xor": "^", "left": "<<", "right": ">>"}


def lower(program: Program) -> Program:
    """Return the program with its functions spelt out, but for those that only coefficients need.

    A program without functions is returned as it is.
    """
    coefficients = program.needed(program.coefficients)
    jacobian = (entry for row in program.jacobian for entry in row)
    rest = program.needed([*program.rhs, *jacobian], program.coefficients)
    if not any(assignment.operation in FUNCTIONS for assignment in rest):
        return program
    recorder = _Recorder()
    for assignment in rest:
        recorder.add(assignment)
    return replace(
        program,
        assignments=(*coefficients, *recorder.assignments),
        rhs=recorder.refs(program.rhs),
        jacobian=tuple(recorder.refs(row) for row in program.jacobian),
        hessian=(),
    )


class _Recorder:
    """An algebra (see `formula.Algebra`) whose values are names, and whose operations become assignments."""

    def __init__(self) -> None:
        self.assignments: list[Assignment] = []
        self._known: dict[tuple[str, str], str] = {}
        self._renamed: dict[Ref, Ref] = {}  # results of functions have the names of their last operation

    def add(self, assignment: Assignment) -> None:
        """Write an assignment of the program."""
        arguments = self.refs(assignment.arguments)
        if assignment.operation in FUNCTIONS:
            result = FUNCTIONS[assignment.operation](self, *(_Term(self, ref) for ref in arguments))
            self._renamed[assignment.target] = result.ref
        else:
            self.assignments.append(Assignment(assignment.target, assignment.operation, arguments))

    def refs(self, refs: Iterable[Ref]) -> tuple[Ref, ...]:
        """Return what the references of the program are here."""
        return tuple(self._renamed.get(ref, ref) for ref in refs)

    def operation(self, name: str, *arguments: Any) -> _Term:
        """Return the result of an operation; one that was done before is not done again."""
        refs = tuple(argument.ref if isinstance(argument, _Term) else argument for argument in arguments)
        key = name, repr(refs)
        if key not in self._known:
            self._known[key] = f"f{len(self._known)}"
            self.assignments.append(Assignment(self._known[key], name, refs))
        return _Term(self, self._known[key])

    def less(self, left: Any, right: Any, first: Any, second: Any) -> _Term:
        return self.operation("select_less", left, right, first, second)

    def less_equal(self, left: Any, right: Any, first: Any, second: Any) -> _Term:
        return self.operation("select_less_equal", left, right, first, second)

    def equal(self, left: Any, right: Any, first: Any, second: Any) -> _Term:
        return self.operation("select_equal", left, right, first, second)

    def bits(self, x: Any) -> _Term:
        return self.operation("bits", x)

    def real(self, k: Any) -> _Term:
        return self.operation("real", k)


def _binary(name: str) -> Callable[[_Term, Any], _Term]:
    return lambda self, other: self.recorder.operation(name, self, other)


def _reflected(name: str) -> Callable[[_Term, Any], _Term]:
    return lambda self, other: self.recorder.operation(name, other, self)


@dataclass(frozen=True)
class _Term:
    """A value of which only the name is known."""

    recorder: _Recorder
    ref: Ref

    __add__, __radd__ = _binary("add"), _reflected("add")
    __sub__, __rsub__ = _binary("sub"), _reflected("sub")
    __mul__, __rmul__ = _binary("mul"), _reflected("mul")
    __truediv__, __rtruediv__ = _binary("div"), _reflected("div")
    __and__, __xor__ = _binary("and"), _binary("xor")
    __lshift__, __rshift__ = _binary("left"), _binary("right")


def operations(assignments: Iterable[Assignment]) -> int:
    """Return how many instructions straight-line assignments are, roughly.

    A select takes a comparison and a blend, a change of type nothing. Products within spelt-out functions are taken
    to fuse with the sums that they go into.
    """
    listed = list(assignments)
    summed = {ref for a in listed if a.operation in ("add", "sub") for ref in a.arguments}
    fused = sum(a.operation == "mul" and a.target in summed and a.target.startswith("f") for a in listed)
    weights = {"bits": 0, "real": 0, "select_less": 2, "select_less_equal": 2, "select_equal": 2}
    return sum(weights.get(a.operation, 1) for a in listed) - fused
