"""Equations in the names of axes and parameters, read with a list of what they may hold; nothing is ever executed."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest

LONGEST = 1000  # characters
POSSIBLE = "it may hold numbers, names of axes and parameters, + - * / ** sqrt( ) and brackets"
_PAIR: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}
_SIGN: dict[type[ast.unaryop], Callable[[Any], Any]] = {ast.USub: np.negative, ast.UAdd: np.positive}


@dataclass(frozen=True)
class Equation:
    """`left = right`, as a difference that is zero where it holds."""

    text: str
    left: ast.expr
    right: ast.expr

    def difference(self, values: Mapping[str, Any]) -> np.ndarray:
        """Return left - right, NaN where a side is no number.

        Parameters
        ----------
        values : mapping
            Number or array by name, for all names that `names` returns.
        """
        with np.errstate(all="ignore"):
            return np.asarray(_value(self.left, values) - _value(self.right, values), dtype=np.float64)

    @property
    def names(self) -> set[str]:
        """Names of axes and parameters that it holds."""
        nodes = (node for side in (self.left, self.right) for node in _parts(side))
        return {node.id for node in nodes if isinstance(node, ast.Name)}


def parse_equation(text: str, names: Sequence[str]) -> Equation:
    """Return an equation in some names.

    Raises
    ------
    ConfigError
        If it is none, or holds anything else than numbers, the names and arithmetic.
    """
    sides = text.split("=")
    if len(sides) != 2 or not all(side.strip() for side in sides):
        raise ConfigError("is not an equation", text, "write left = right, for example c = 5")
    if len(text) > LONGEST:
        raise ConfigError(f"the equation is longer than {LONGEST} characters", f"{text[:40]}...")
    equation = Equation(text.strip(), *(_parse(side, text) for side in sides))
    for name in sorted(equation.names):
        if name not in names:
            hint = nearest(name, names)
            raise ConfigError(f"nothing is called {name}{hint}", text, f"there are {', '.join(names)}")
    return equation


def _parse(side: str, text: str) -> ast.expr:
    try:
        tree = ast.parse(side.strip(), mode="eval").body
        for node in _parts(tree):
            _check(node, text)
    except (SyntaxError, ValueError, OverflowError, RecursionError, MemoryError) as error:
        raise ConfigError(f"{side.strip()} cannot be read", text, POSSIBLE) from error
    return tree


def _check(node: ast.expr, text: str) -> None:
    """Raise if a part of an equation is none of those that are known."""
    match node:
        case ast.BinOp(op=operator) if type(operator) in _PAIR:
            return
        case ast.UnaryOp(op=sign) if type(sign) in _SIGN:
            return
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool) and np.isfinite(float(value)):
            return
        case ast.Call(func=ast.Name(id="sqrt"), args=[_], keywords=[]) | ast.Name():
            return
    raise ConfigError(f"{ast.unparse(node)} is not accepted", text, POSSIBLE)


def _parts(node: ast.expr) -> list[ast.expr]:
    """Return a node and all below it, without the names of functions."""
    match node:
        case ast.BinOp(left=left, right=right):
            return [node, *_parts(left), *_parts(right)]
        case ast.UnaryOp(operand=operand):
            return [node, *_parts(operand)]
        case ast.Call(args=arguments):
            return [node, *(part for argument in arguments for part in _parts(argument))]
    return [node]


def _value(node: ast.expr, values: Mapping[str, Any]) -> Any:
    """Return the value of an expression that has been checked."""
    match node:
        case ast.BinOp(left=left, op=operator, right=right):
            return _PAIR[type(operator)](_value(left, values), _value(right, values))
        case ast.UnaryOp(op=sign, operand=operand):
            return _SIGN[type(sign)](_value(operand, values))
        case ast.Call(args=[argument]):
            return np.sqrt(_value(argument, values))
        case ast.Name(id=name):
            return np.asarray(values[name], dtype=np.float64)
        case ast.Constant(value=int() | float() as number):
            return np.float64(number)
    raise AssertionError(ast.dump(node))
