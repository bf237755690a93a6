"""Functions for the equations of a model, of floats, complex numbers, arrays and symbols alike.

A model's equations are called with floats, and once with symbols to derive the program. `math.sin` takes the first
only; `sympy.sin` takes both but loads SymPy with the model. These take what they are given to the package that it
comes from, and import nothing. SymPy's own functions may be used all the same.
"""

from __future__ import annotations

import cmath
import math
import sys
from typing import Any

__all__ = [
    "absolute",
    "cos",
    "cosh",
    "exp",
    "log",
    "maximum",
    "minimum",
    "sign",
    "sin",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "where",
]


def sin(x: Any) -> Any:
    """Return the sine of an angle in radians."""
    return _call("sin", x)


def cos(x: Any) -> Any:
    """Return the cosine of an angle in radians."""
    return _call("cos", x)


def tan(x: Any) -> Any:
    """Return the tangent of an angle in radians."""
    return _call("tan", x)


def exp(x: Any) -> Any:
    """Return e to the power x."""
    return _call("exp", x)


def log(x: Any) -> Any:
    """Return the natural logarithm."""
    return _call("log", x)


def sinh(x: Any) -> Any:
    """Return the hyperbolic sine."""
    return _call("sinh", x)


def cosh(x: Any) -> Any:
    """Return the hyperbolic cosine."""
    return _call("cosh", x)


def tanh(x: Any) -> Any:
    """Return the hyperbolic tangent."""
    return _call("tanh", x)


def sqrt(x: Any) -> Any:
    """Return the square root."""
    return _call("sqrt", x)


def where(condition: Any, first: Any, second: Any) -> Any:
    """Return `first` where the condition holds, else `second`; conditions of symbols are joined by & and |."""
    if isinstance(condition, bool):
        return first if condition else second
    package = _package(condition)
    if hasattr(package, "where"):
        return package.where(condition, first, second)[()]
    return package.Piecewise((first, condition), (second, True))


def absolute(x: Any) -> Any:
    """Return |x|; of a complex number x or -x, by the sign of its real part, as complex steps want it."""
    return where(_ordered(x) < 0, -x, x)


def minimum(x: Any, y: Any) -> Any:
    """Return the smaller of two; complex numbers are compared by their real parts."""
    return where(_ordered(y) < _ordered(x), y, x)


def maximum(x: Any, y: Any) -> Any:
    """Return the larger of two; complex numbers are compared by their real parts."""
    return where(_ordered(x) < _ordered(y), y, x)


def sign(x: Any) -> Any:
    """Return -1, 0 or 1; of a complex number the sign of its real part."""
    return where(_ordered(x) < 0, -1, where(_ordered(x) > 0, 1, 0))


def _ordered(x: Any) -> Any:
    return getattr(x, "real", x)


def _call(name: str, x: Any) -> Any:
    return getattr(_package(x), name)(x)


def _package(x: Any) -> Any:
    """Return the package that has the functions of such an argument."""
    name = type(x).__module__.partition(".")[0]
    if name == "builtins":
        return cmath if isinstance(x, complex) else math
    return sys.modules[name]
