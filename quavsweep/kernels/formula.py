"""Elementary functions as straight-line formulas of + - * / and bits: printed into kernels, run on arrays.

NumPy's and libm's functions differ in their bits between processors and versions, and a call in a loop over lanes is
not vectorised. These formulas are all there is: `Arrays` runs them, `quavsweep.kernels.lower` prints them.

A product that is subtracted may be fused or not, as the machine has it: where a rounding would matter the product is
exact in both cases. Errors in units of the last place (ulp) are the largest that the tests have seen.

| function | error | range |
|---|---|---|
| sin, cos | 1.5 | abs(x) <= 2^20; beyond, that of an angle rounded to float64; NaN beyond 2^40 |
| tan | 1.8 | as for sin and cos |
| exp | 1.1 | all; subnormal below -708.4, 0 below -745.2, infinite above 709.78 |
| log | 1.0 | all; -inf at 0, NaN below |
| tanh | 1.4 | all |
| sinh, cosh | 1.6 | abs(x) <= 709.78; infinite beyond |

References
----------
.. [1] W. J. Cody, W. Waite, Software Manual for the Elementary Functions (1980): reduction by parts of a constant.
.. [2] J.-M. Muller, Elementary Functions, 3rd ed. (2016), chapters 4 and 11.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from quavsweep.kernels.minimax import (
    COSINE,
    EXPONENTIAL,
    HYPERBOLIC_SINE,
    HYPERBOLIC_TANGENT,
    LOGARITHM,
    SINE,
)

MAGIC = 1.5 * 2.0**52  # x + MAGIC is rounded to a whole number, which its low bits hold
MAGIC_BITS = 0x4338 << 48
LIMIT = 2.0**40  # sines of larger numbers are NaN: their last place is too coarse to be an angle
QUARTER = 0.6366197723675814  # 2 / pi
# pi / 2 and ln 2 in parts; all but the last are short, so that n times a part is exact.
HALF_PI = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487111665e-21, 8.4784276603689e-32)
LN_2 = (0.693147180559663, 2.8235290563031577e-13)
LOG2_E = 1.4426950408889634
UNDERFLOW, OVERFLOW = -746.0, 710.0  # beyond, exp is 0 or infinite anyway
ROOT_BITS = 0x3FE6A09E667F3BCD  # of sqrt(1/2)
TINY = 2.0**-1022
SMALL_TANH, SMALL_SINH = 0.5625, 1.0
EXPONENT, BIAS = 52, 1023


class Algebra(Protocol):
    """What formulas need besides operators."""

    def less(self, left: Any, right: Any, first: Any, second: Any) -> Any:
        """Return `first` where left < right, else `second`; so for NaN."""

    def less_equal(self, left: Any, right: Any, first: Any, second: Any) -> Any:
        """Return `first` where left <= right, else `second`; so for NaN."""

    def equal(self, left: Any, right: Any, first: Any, second: Any) -> Any:
        """Return `first` where two whole numbers are equal, else `second`."""

    def bits(self, x: Any) -> Any:
        """Return the 64 bits of a float as a whole number."""

    def real(self, k: Any) -> Any:
        """Return the float that has these bits."""


class Arrays:
    """Formulas on floats and arrays of NumPy."""

    def less(self, left: Any, right: Any, first: Any, second: Any) -> Any:
        """Choose by left < right."""
        return np.where(np.less(left, right), first, second)[()]

    def less_equal(self, left: Any, right: Any, first: Any, second: Any) -> Any:
        """Choose by left <= right."""
        return np.where(np.less_equal(left, right), first, second)[()]

    def equal(self, left: Any, right: Any, first: Any, second: Any) -> Any:
        """Choose by left == right."""
        return np.where(np.equal(left, right), first, second)[()]

    def bits(self, x: Any) -> Any:
        """View floats as whole numbers."""
        return np.asarray(x, dtype=np.float64).view(np.int64)[()]

    def real(self, k: Any) -> Any:
        """View whole numbers as floats."""
        return np.asarray(k, dtype=np.int64).view(np.float64)[()]


def polynomial(x: Any, coefficients: Sequence[float]) -> Any:
    """Return a polynomial by Estrin's scheme, whose chain of operations is short."""
    terms: list[Any] = list(coefficients)
    while len(terms) > 1:
        pairs = [low + high * x for low, high in zip(terms[::2], terms[1::2], strict=False)]
        terms = pairs + terms[2 * len(pairs) :]
        x = x * x
    return terms[0]


def sin(op: Algebra, x: Any) -> Any:
    """Return the sine."""
    quarters, r, _, last = _turned(op, x)
    r = r - last
    return _flip(op, op.equal(quarters & 1, 0, r + _sine(r), 1.0 + _cosine(r)), quarters)


def cos(op: Algebra, x: Any) -> Any:
    """Return the cosine."""
    quarters, r, _, last = _turned(op, x)
    r = r - last
    return _flip(op, op.equal(quarters & 1, 0, 1.0 + _cosine(r), r + _sine(r)), quarters + 1)


def tan(op: Algebra, x: Any) -> Any:
    """Return the tangent, from sine and cosine in two parts each; in every other quarter their places change."""
    quarters, r, rest, last = _turned(op, x)
    rest = rest - last
    sine, sine_rest = _two_parts(r, _sine(r) + rest)
    cosine, cosine_rest = _two_parts(1.0, _cosine(r) - r * rest)
    over, over_rest = op.equal(quarters & 1, 0, sine, cosine), op.equal(quarters & 1, 0, sine_rest, cosine_rest)
    under, under_rest = op.equal(quarters & 1, 0, cosine, sine), op.equal(quarters & 1, 0, cosine_rest, sine_rest)
    ratio = over / under
    # The sum is `under` once more, but compilers cannot know: two quotients by one number become two products.
    correction = (over_rest - ratio * under_rest) / (under + under_rest)
    return _flip(op, ratio + correction, quarters + quarters)


def _turned(op: Algebra, x: Any) -> tuple[Any, Any, Any, Any]:
    """Return the quarter turns in x, in the low bits of a whole number, and what is left: r + rest - last.

    n times one of the first three parts of pi / 2 is exact, and so are the differences where digits cancel.
    """
    turns = x * QUARTER + MAGIC
    n = turns - MAGIC
    far = x - n * HALF_PI[0]
    near = far - n * HALF_PI[1]
    lost = ((far - near) - n * HALF_PI[1]) - n * HALF_PI[2]
    r = op.less_equal(x * x, LIMIT**2, near + lost, math.nan)
    return op.bits(turns), r, (near - r) + lost, n * HALF_PI[3]


def _sine(r: Any) -> Any:
    """Return sin(r) - r."""
    z = r * r
    return r * z * polynomial(z, SINE)


def _cosine(r: Any) -> Any:
    """Return cos(r) - 1."""
    z = r * r
    return z * z * polynomial(z, COSINE) - 0.5 * z


def _two_parts(large: Any, small: Any) -> tuple[Any, Any]:
    """Return a sum and its rounding error."""
    total = large + small
    return total, (large - total) + small


def _flip(op: Algebra, x: Any, quarters: Any) -> Any:
    """Return x with its sign changed in the second half of a turn: bit 1 is moved to the sign's place."""
    return op.real(op.bits(x) ^ ((quarters & 2) << 62))


def exp(op: Algebra, x: Any) -> Any:
    """Return e^x = 2^n e^r, scaled in two steps so that neither leaves the range of exponents."""
    x = op.less(x, UNDERFLOW, UNDERFLOW, x)
    x = op.less(OVERFLOW, x, OVERFLOW, x)
    turns = x * LOG2_E + MAGIC
    n = turns - MAGIC
    r = (x - n * LN_2[0]) - n * LN_2[1]
    grown = 1.0 + (r + r * r * polynomial(r, EXPONENTIAL))
    whole = op.bits(turns)
    half = whole >> 1
    return grown * op.real((half + BIAS) << EXPONENT) * op.real((whole - half + BIAS) << EXPONENT)


def log(op: Algebra, x: Any) -> Any:
    """Return ln(x) = n ln 2 + ln(1 + f); with s = f / (2 + f) the last is f - s (f - s^2 Q(s^2))."""
    bits = op.bits(op.less(x, TINY, x * 2.0**54, x))
    whole = (bits - ROOT_BITS) >> EXPONENT
    n = (op.real(whole + MAGIC_BITS) - MAGIC) + op.less(x, TINY, -54.0, 0.0)
    f = op.real(bits - (whole << EXPONENT)) - 1.0
    s = f / (2.0 + f)
    z = s * s
    value = n * LN_2[0] - ((s * (f - z * polynomial(z, LOGARITHM)) - n * LN_2[1]) - f)
    value = op.less(x, math.inf, value, math.inf)
    return op.less(0.0, x, value, op.less_equal(0.0, x, -math.inf, math.nan))


def tanh(op: Algebra, x: Any) -> Any:
    """Return the hyperbolic tangent, 1 - 2 / (e^2x + 1), and a polynomial for small x."""
    size, z = _size(op, x), x * x
    small = x + x * z * polynomial(z, HYPERBOLIC_TANGENT)
    large = 1.0 - 2.0 / (exp(op, size + size) + 1.0)
    return op.less(size, SMALL_TANH, small, _signed(op, large, x, size))


def sinh(op: Algebra, x: Any) -> Any:
    """Return the hyperbolic sine, (e^x - e^-x) / 2, and a polynomial for small x."""
    size, z = _size(op, x), x * x
    small = x + x * z * polynomial(z, HYPERBOLIC_SINE)
    grown = exp(op, size)
    return op.less(size, SMALL_SINH, small, _signed(op, 0.5 * grown - 0.5 / grown, x, size))


def cosh(op: Algebra, x: Any) -> Any:
    """Return the hyperbolic cosine, (e^x + e^-x) / 2."""
    grown = exp(op, _size(op, x))
    return 0.5 * grown + 0.5 / grown


def _size(op: Algebra, x: Any) -> Any:
    return op.real(op.bits(x) & 0x7FFFFFFFFFFFFFFF)


def _signed(op: Algebra, value: Any, x: Any, size: Any) -> Any:
    """Return the value with the sign of x."""
    return op.real(op.bits(value) ^ (op.bits(x) ^ op.bits(size)))


FUNCTIONS: dict[str, Callable[[Any, Any], Any]] = {f.__name__: f for f in (sin, cos, tan, exp, log, sinh, cosh, tanh)}


def on_arrays(name: str) -> Callable[[Any], Any]:
    """Return a function of floats or arrays."""
    formula = FUNCTIONS[name]

    def function(x: Any) -> Any:
        with np.errstate(all="ignore"):
            return formula(Arrays(), np.asarray(x, dtype=np.float64)[()])

    return function
