"""Piecewise functions as choices between two expressions by one comparison, the only form that is compiled.

SymPy's own forms differentiate to DiracDelta and simplify conditions at length. A choice differentiates branch by
branch; what happens where its sides are equal is left to those who ask `Program.switches`.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from quavsweep.errors import ModelError


class _Choice(sp.Function):  # type: ignore[misc]
    """A function of left, right, first, second: `first` where the comparison holds, else `second`."""

    nargs = 4
    is_extended_real = True

    @classmethod
    def eval(cls, left: sp.Expr, right: sp.Expr, first: sp.Expr, second: sp.Expr) -> sp.Expr | None:
        if first == second:
            return first
        if left.is_number and right.is_number:
            return first if cls.holds(left, right) else second
        return None

    def _eval_derivative(self, symbol: sp.Symbol) -> sp.Expr:
        left, right, first, second = self.args
        return self.func(left, right, first.diff(symbol), second.diff(symbol))


class Less(_Choice):
    """`first` where left < right."""

    @staticmethod
    def holds(left: sp.Expr, right: sp.Expr) -> bool:
        """Return whether the comparison holds for two numbers."""
        return bool(left < right)


class LessEqual(_Choice):
    """`first` where left <= right."""

    @staticmethod
    def holds(left: sp.Expr, right: sp.Expr) -> bool:
        """Return whether the comparison holds for two numbers."""
        return bool(left <= right)


def as_choices(expression: sp.Expr, where: str) -> sp.Expr:
    """Return an expression with Piecewise, Abs, Min, Max, sign and Heaviside as choices.

    Raises
    ------
    ModelError
        If a condition is not made of comparisons, or a Piecewise has no last branch; `where` is said with it.
    """
    rules = {
        sp.Piecewise: lambda *branches: _piecewise(branches, where),
        sp.Abs: lambda x: Less(x, 0, -x, x),
        sp.sign: lambda x: Less(x, 0, -1, Less(0, x, 1, 0)),
        sp.Heaviside: lambda x, at_zero: Less(x, 0, 0, Less(0, x, 1, at_zero)),
        sp.Max: lambda *values: _extreme(values, lambda x, y: Less(x, y, y, x)),
        sp.Min: lambda *values: _extreme(values, lambda x, y: Less(y, x, y, x)),
    }
    for kind, rule in rules.items():
        expression = expression.replace(kind, rule)
    return expression


def _extreme(values: tuple[sp.Expr, ...], pick: Any) -> sp.Expr:
    # Constants come last, so that NaN in the others is not lost.
    first, *rest = sorted(values, key=lambda value: bool(value.is_number))
    for value in rest:
        first = pick(first, value)
    return first


def _piecewise(branches: tuple[Any, ...], where: str) -> sp.Expr:
    *conditional, (result, last) = branches
    if last != sp.true:
        raise ModelError("a Piecewise has no branch for all other cases", where, "its last one may be (value, True)")
    for value, condition in reversed(conditional):
        result = _choose(condition, value, result, where)
    return result


def _choose(condition: Any, first: sp.Expr, second: sp.Expr, where: str) -> sp.Expr:
    """Return `first` where the condition holds, else `second`."""
    if condition in (sp.true, sp.false):
        return first if condition == sp.true else second
    if isinstance(condition, sp.Not):
        return _choose(condition.args[0], second, first, where)
    if isinstance(condition, sp.And | sp.Or):
        head, *others = condition.args
        rest = _choose(condition.func(*others), first, second, where)
        both = (rest, second) if isinstance(condition, sp.And) else (first, rest)
        return _choose(head, *both, where)
    if isinstance(condition, sp.core.relational.Relational):
        left, right = condition.lhs, condition.rhs
        match type(condition):
            case sp.StrictLessThan:
                return Less(left, right, first, second)
            case sp.StrictGreaterThan:
                return Less(right, left, first, second)
            case sp.LessThan:
                return LessEqual(left, right, first, second)
            case sp.GreaterThan:
                return LessEqual(right, left, first, second)
            case sp.Equality:
                return LessEqual(left, right, LessEqual(right, left, first, second), second)
            case sp.Unequality:
                return _choose(sp.Eq(left, right), second, first, where)
    raise ModelError(f"the condition {condition} cannot be compiled", where, "comparisons joined by & and | can")
