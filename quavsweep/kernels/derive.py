"""Deriving a Program from a model's equations with SymPy: Jacobian, Hessian, hoisted coefficients, shared terms."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import sympy as sp

from quavsweep.errors import ModelError
from quavsweep.kernels.choice import Less, LessEqual, as_choices
from quavsweep.kernels.program import TIME, TIME_SCALE, Assignment, Program, Ref
from quavsweep.models.mistake import mistake, place, place_of_return, place_of_value

if TYPE_CHECKING:
    from quavsweep.models import Model, Observable

LARGEST_POWER = 16
FUNCTIONS = {
    sp.sin: "sin",
    sp.cos: "cos",
    sp.tan: "tan",
    sp.exp: "exp",
    sp.log: "log",
    sp.sinh: "sinh",
    sp.cosh: "cosh",
    sp.tanh: "tanh",
    Less: "select_less",
    LessEqual: "select_less_equal",
}
POSSIBLE = (
    "its equations may use + - * / **, sqrt, exp, log, sin, cos, tan, sinh, cosh, tanh, Abs, Min, Max, sign, Piecewise"
)


def derive(model: Model) -> Program:
    """Return the program of a model.

    Raises
    ------
    ModelError
        If the equations cannot be evaluated with symbols, or use a function that is not supported; with the line
        where that is known.
    """
    u, p, time = _symbols(model)
    rhs = _derivatives(model, u, p, time)
    period = _period(model, p)
    try:
        return _program(model, u, p, time, rhs, period)
    except ModelError as error:
        if error.where != model.name:
            raise
        if model.forcing_period is not None and not _compilable(period, u):
            raise ModelError(error.what, place(model.forcing_period), error.possible) from error
        raise ModelError(error.what, _place(model, u, p, time), error.possible) from error


def derive_observables(model: Model) -> Program:
    """Return the program of a model's observables: first their values, then their rates of change along orbits.

    Raises
    ------
    ModelError
        If an observable cannot be evaluated with symbols, or uses a function that is not supported.
    """
    u, p, time = _symbols(model)
    derivatives = [as_choices(f, model.name) for f in _derivatives(model, u, p, time)]
    known = {**dict(zip((*model.state_names, *model.parameter_names), (*u, *p), strict=True)), "t": time}
    values = [_observed(observable, known) for observable in model.observables]
    flow = [*zip(u, derivatives, strict=True), (time, sp.Integer(1))]
    rates = [sp.Add(*(sp.diff(value, x) * f for x, f in flow)) for value in values]
    writer = _Writer(model.name, u)
    refs = writer.write([*values, *(as_choices(rate, model.name) for rate in rates), _period(model, p)])
    return Program(
        states=tuple(x.name for x in u),
        parameters=tuple(x.name for x in p),
        coefficients=(),
        assignments=tuple(writer.assignments),
        rhs=tuple(refs[:-1]),
        jacobian=(),
        hessian=(),
        period=refs[-1],
    )


def returned(model: Model) -> tuple[str, ...]:
    """Return what equations, forcing period and observables of a model return for symbols, exactly, as text.

    Raises
    ------
    ModelError
        If one of them cannot be evaluated with symbols.
    """
    u, p, time = _symbols(model)
    known = {**dict(zip((*model.state_names, *model.parameter_names), (*u, *p), strict=True)), "t": time}
    values = [*_derivatives(model, u, p, time), _period(model, p)]
    values += [_observed(observable, known) for observable in model.observables]
    return tuple(sp.srepr(value) for value in values)


def _observed(observable: Observable, known: dict[str, sp.Symbol]) -> sp.Expr:
    """Return an observable as an expression that can be compiled."""
    try:
        value = observable.value(known)
    except Exception as error:  # whatever a user's function may raise
        raise mistake(error, observable.function) from error
    where = place_of_return(observable.function)
    expression = as_choices(_expression(value, where, f"the observable {observable.name}"), where)
    for unknown in (call for call in expression.atoms(sp.Function) if type(call) not in FUNCTIONS):
        raise ModelError(f"{type(unknown).__name__} cannot be compiled", where, POSSIBLE)
    _Writer(where, []).write([expression])
    return expression


def _symbols(model: Model) -> tuple[list[sp.Symbol], list[sp.Symbol], sp.Symbol]:
    """Return the symbols of states, parameters and time."""
    u = [sp.Symbol(f"u_{name}", real=True) for name in model.state_names]
    p = [sp.Symbol(f"p_{name}", real=True) for name in model.parameter_names]
    return u, p, sp.Symbol(TIME, real=True)


def _program(
    model: Model, u: list[sp.Symbol], p: list[sp.Symbol], time: sp.Symbol, rhs: list[sp.Expr], period: sp.Expr
) -> Program:
    """Return the program of derivatives and a period of the forcing."""
    scale = sp.Symbol(TIME_SCALE, real=True)
    rhs = [sp.Add(*(scale * term for term in sp.Add.make_args(f))) for f in rhs]
    rhs = [as_choices(f, model.name) for f in rhs]
    for unknown in (call for f in (*rhs, period) for call in f.atoms(sp.Function) if type(call) not in FUNCTIONS):
        raise ModelError(f"{type(unknown).__name__} cannot be compiled", model.name, POSSIBLE)
    jacobian = [[as_choices(sp.diff(f, x), model.name) for x in u] for f in rhs]
    hessian = [[[as_choices(sp.diff(f, x), model.name) for x in u] for f in row] for row in jacobian]
    writer = _Writer(model.name, [*u, time] if model.forcing_period else u)
    flat = [*rhs, *(f for row in jacobian for f in row), *(f for m in hessian for row in m for f in row)]
    refs = iter(writer.write([*(writer.hoist(f) for f in flat), period]))
    count = range(len(u))
    return Program(
        states=tuple(x.name for x in u),
        parameters=tuple(x.name for x in p),
        coefficients=(*writer.used_coefficients(), *([TIME_SCALE] if model.forcing_period else [])),
        assignments=tuple(writer.assignments),
        rhs=tuple(next(refs) for _ in count),
        jacobian=tuple(tuple(next(refs) for _ in count) for _ in count),
        hessian=tuple(tuple(tuple(next(refs) for _ in count) for _ in count) for _ in count),
        period=next(refs),
    )


def _derivatives(model: Model, u: list[sp.Symbol], p: list[sp.Symbol], time: sp.Symbol) -> list[sp.Expr]:
    """Return the derivatives as expressions, one per state."""
    names = model.state_names
    try:
        values = model.field(u, p, time)
    except Exception as error:  # whatever a user's function may raise
        raise mistake(error, model.rhs) from error
    where, named = place_of_return(model.rhs), ", ".join(names)
    if isinstance(values, sp.Expr | str) or not isinstance(values, Iterable):
        what = f"the equations return {'a single value' if isinstance(values, sp.Expr) else values}"
        raise ModelError(what, where, f"they return the derivatives of {named} in a tuple")
    values = tuple(values)
    if len(values) != len(names):
        without = f", so {', '.join(names[len(values) :])} has no derivative" if len(values) < len(names) else ""
        what = f"the equations return {len(values)} derivatives for {len(names)} states{without}"
        raise ModelError(what, where, f"they return those of {named}, in this order")
    return [_expression(value, where, f"the derivative of {x}") for x, value in zip(names, values, strict=True)]


def _period(model: Model, p: list[sp.Symbol]) -> sp.Expr:
    """Return the period of the forcing, 0 if there is none."""
    period = model.forcing_period
    if period is None:
        return sp.Integer(0)
    try:
        value = model.forcing(dict(zip(model.parameter_names, p, strict=True)))
    except Exception as error:  # whatever a user's function may raise
        raise mistake(error, period) from error
    return as_choices(_expression(value, place(period), "the forcing period"), model.name)


def _expression(value: Any, where: str, what: str) -> sp.Expr:
    """Return a value of a user's function as an expression."""
    try:
        expression = sp.Integer(value) if type(value) is int else sp.sympify(value, strict=True)
    except sp.SympifyError as error:
        raise ModelError(f"{what} is {value!r}, which is no number or expression", where) from error
    if not isinstance(expression, sp.Expr):
        raise ModelError(f"{what} is {expression}, which is no number or expression", where)
    return expression


def _place(model: Model, u: list[sp.Symbol], p: list[sp.Symbol], time: sp.Symbol) -> str:
    """Return file and line where the equations first have a value that cannot be compiled."""
    known: dict[sp.Expr, bool] = {}

    def wrong(value: Any) -> bool:
        if isinstance(value, tuple | list):
            return any(map(wrong, value))
        if not isinstance(value, sp.Expr):
            return False
        if value not in known:
            known[value] = not _compilable(value, [*u, time])
        return known[value]

    return place_of_value(model.rhs, lambda: model.field(u, p, time), wrong)


def _compilable(value: sp.Expr, states: list[sp.Symbol]) -> bool:
    """Whether an expression can be compiled."""
    writer = _Writer("", states)
    try:
        writer.write([writer.hoist(as_choices(value, ""))])
    except ModelError:
        return False
    return True


class _Writer:
    """Turns expressions into assignments; equal subexpressions become one assignment."""

    def __init__(self, where: str, states: list[sp.Symbol]) -> None:
        self.where = where
        self.states = states
        self.coefficients: dict[sp.Expr, sp.Symbol] = {}
        self.assignments: list[Assignment] = []
        self.known: dict[tuple[str, tuple[Ref, ...]], str] = {}
        self.unnamed: set[str] = set()  # temporaries that may still be given a name
        self.count = 0

    def hoist(self, expression: sp.Expr) -> sp.Expr:
        """Return the expression with everything that depends on parameters alone behind a coefficient's symbol."""
        if not expression.has(*self.states):
            return self._coefficient(expression)
        if expression.is_Mul:
            factor, rest = expression.as_independent(*self.states, as_Add=False)
            if factor != 1 and isinstance(rest, Less | LessEqual):
                left, right, first, second = rest.args
                return self.hoist(rest.func(left, right, sp.expand_mul(factor * first), sp.expand_mul(factor * second)))
            if factor != 1 and not rest.is_polynomial(*self.states):
                return self._coefficient(factor) * self.hoist(rest)
        if expression.is_polynomial(*self.states):
            terms = sp.Poly(expression, *self.states).terms()
            return self._nested({powers: self._coefficient(value) for powers, value in terms})
        return expression.func(*(self.hoist(argument) for argument in expression.args))

    def _coefficient(self, value: sp.Expr) -> sp.Expr:
        value = sp.factor(value)
        if value.is_number:
            return value
        return self.coefficients.setdefault(value, sp.Symbol(f"c{len(self.coefficients)}", real=True))

    def _nested(self, terms: dict[tuple[int, ...], sp.Expr]) -> sp.Expr:
        """Return a polynomial in nested form: the state that most terms share is taken out first."""
        shared = Counter(i for powers in terms for i, power in enumerate(powers) if power)
        i, count = max(shared.items(), key=lambda item: (item[1], -item[0]), default=(0, 0))
        if count < 2:
            products = (
                sp.Mul(c, *(u**k for u, k in zip(self.states, powers, strict=True))) for powers, c in terms.items()
            )
            return sp.Add(*products)
        inside = {(*w[:i], w[i] - 1, *w[i + 1 :]): c for w, c in terms.items() if w[i]}
        outside = {w: c for w, c in terms.items() if not w[i]}
        factored = sp.Mul(self.states[i], self._nested(inside), evaluate=False)
        return sp.Add(factored, self._nested(outside), evaluate=False) if outside else factored

    def write(self, expressions: list[sp.Expr]) -> list[Ref]:
        """Write assignments for coefficients and expressions; return where each expression's value is."""
        values, symbols = list(self.coefficients), list(self.coefficients.values())
        shared, reduced = sp.cse(values, symbols=sp.numbered_symbols("a"), order="canonical")
        for symbol, value in shared:
            self._assign(symbol.name, value)
        for symbol, value in zip(symbols, reduced, strict=True):
            self._assign(symbol.name, value)
        shared, reduced = sp.cse(expressions, symbols=sp.numbered_symbols("s"), order="canonical")
        for symbol, value in shared:
            self._assign(symbol.name, value)
        return [self._ref(value) for value in reduced]

    def used_coefficients(self) -> tuple[str, ...]:
        """Return the coefficients' names, in order of appearance."""
        return tuple(symbol.name for symbol in self.coefficients.values())

    def _assign(self, target: str, expression: sp.Expr) -> None:
        """Write an assignment to a name that later expressions use."""
        ref = self._ref(expression)
        if isinstance(ref, str) and ref in self.unnamed and self.assignments[-1].target == ref:
            self.unnamed.discard(ref)
            last = self.assignments.pop()
            self.known[(last.operation, last.arguments)] = target
            self.assignments.append(Assignment(target, last.operation, last.arguments))
        else:
            self.assignments.append(Assignment(target, "add", (ref, 0.0)))

    def _operation(self, operation: str, *arguments: Ref) -> Ref:
        key = (operation, arguments)
        if key not in self.known:
            self.known[key] = f"t{self.count}"
            self.count += 1
            self.unnamed.add(self.known[key])
            self.assignments.append(Assignment(self.known[key], operation, arguments))
        return self.known[key]

    def _ref(self, expression: sp.Expr) -> Ref:
        if expression.is_Symbol:
            return str(expression.name)
        if expression.is_number:
            return self._number(expression)
        if expression.is_Add:
            return self._sum(expression)
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow:
            return self._power(expression)
        if type(expression) in FUNCTIONS:
            return self._operation(FUNCTIONS[type(expression)], *(self._ref(x) for x in expression.args))
        raise ModelError(f"{type(expression).__name__} cannot be compiled", self.where, POSSIBLE)

    def _number(self, expression: sp.Expr) -> float:
        value = complex(expression) if expression.is_finite is not False else complex("nan")
        if value.imag or not math.isfinite(value.real):
            name = "zoo, a division by zero," if expression is sp.zoo else expression
            raise ModelError(f"{name} is not a finite real number", self.where, "constants must be")
        return value.real

    def _sum(self, expression: sp.Expr) -> Ref:
        # A term with a minus sign is subtracted; the sum starts with a term that has none.
        terms = sorted(expression.args, key=lambda term: bool(term.could_extract_minus_sign()))
        total = self._ref(terms[0])
        for term in terms[1:]:
            if term.could_extract_minus_sign():
                total = self._operation("sub", total, self._ref(-term))
            else:
                total = self._operation("add", total, self._ref(term))
        return total

    def _product(self, expression: sp.Expr) -> Ref:
        if expression.args[0] == -1:
            return self._operation("neg", self._ref(sp.Mul(*expression.args[1:], evaluate=False)))
        over, under = [], []
        for factor in expression.args:
            base, power = factor.as_base_exp()
            if (2 * power).is_Integer and power < 0:
                under.append(base**-power)
            else:
                over.append(factor)
        product = self._chain(over) if over else 1.0
        return self._operation("div", product, self._chain(under)) if under else product

    def _chain(self, factors: list[sp.Expr]) -> Ref:
        product: Any = self._ref(factors[0])
        for factor in factors[1:]:
            product = self._operation("mul", product, self._ref(factor))
        return product  # type: ignore[no-any-return]

    def _power(self, expression: sp.Expr) -> Ref:
        base, power = expression.args
        if not (2 * power).is_Integer or abs(power) > LARGEST_POWER:
            # Not by exp and log unasked: the error in ulp would be the size of power * log(base).
            other = "" if power.is_number else "; exp(power * log(base)) does it less accurately"
            raise ModelError(
                f"the power {sp.sstr(power, full_prec=False)} cannot be compiled",
                self.where,
                f"multiples of 1/2 up to {LARGEST_POWER} can{other}",
            )
        if power < 0:
            return self._operation("div", 1.0, self._ref(base**-power))
        whole = self._whole_power(self._ref(base), int(power))
        if power.is_Integer:
            return whole
        root = self._operation("sqrt", self._ref(base))
        return self._operation("mul", root, whole) if power > 1 else root

    def _whole_power(self, ref: Ref, power: int) -> Ref:
        if power < 2:
            return ref if power else 1.0
        half = self._whole_power(ref, power // 2)
        square = self._operation("mul", half, half)
        return self._operation("mul", square, ref) if power % 2 else square
