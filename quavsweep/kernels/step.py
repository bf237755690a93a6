"""Printing one step of W lanes: a method's stages for the state and its tangent vectors, in a straight line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from quavsweep.kernels.layout import Layout
from quavsweep.kernels.lower import WHOLE
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import TIME, TIME_SCALE, Assignment, Program, Ref

# Stages times rows that one loop over lanes computes; beyond, few of them stay in registers. With a loop for the state
# and one for the tangent vectors, a step of dp8 with D = 3 takes 0.85 of the time, one of RK4 with D = 12 0.77 (and
# 0.65 of the time to compile). Below, one loop for all is faster by 2 to 6 %.
LARGEST_JOINT = 100

_SYMBOLS = {"add": "+", "sub": "-", "mul": "*", "div": "/", **WHOLE}
_RELATIONS = {"select_less": "<", "select_less_equal": "<=", "select_equal": "=="}


class Lines:
    """The body of a loop over lanes `i`, reading and writing rows of the group `g`."""

    def __init__(self, layout: Layout) -> None:
        self.lines: list[str] = []
        self._lanes = layout.lanes

    def load(self, name: str, rows: Iterable[int], first: int = 0, offset: str = "") -> None:
        """Load rows into names that count from the row `first`; rows of the group begin at the name `offset`."""
        self.lines += [f"{name}{row - first} = {self.at(row, offset)}" for row in rows]

    def store(self, row: int, value: str, offset: str = "") -> None:
        """Store a value in a row."""
        self.lines.append(f"{self.at(row, offset)} = {value}")

    def let(self, target: str, value: str) -> None:
        """Give a value a name."""
        self.lines.append(f"{target} = {value}")

    def at(self, row: int, offset: str = "") -> str:
        """Return the lane's element of a row."""
        return f"g[{offset and f'{offset} + '}{row * self._lanes} + i]"

    def loop(self) -> list[str]:
        """Return the loop."""
        return [f"for i in range({self._lanes}):", *("    " + line for line in self.lines)]


def choose_layout(
    program: Program, method: ButcherTable, vectors: int, lanes: int, last_from_trace: bool = False, trace: bool = False
) -> Layout:
    """Return the layout of the faster form of a step, see `print_step`.

    The integral of the trace is followed where an exponent is made of it, and as a check of all of them where the
    divergence depends on the state; `trace` asks for it in any case.
    """
    trace = trace or last_from_trace or (vectors == program.dimension and not program.has_constant_divergence)
    coefficients = len(program.coefficients)
    joint = Layout(
        program.dimension,
        vectors,
        coefficients,
        lanes,
        trace,
        last_from_trace=last_from_trace,
        phase=program.forced,
    )
    if not vectors or method.stages * joint.stretch_row <= LARGEST_JOINT:
        return joint
    return replace(joint, scratch=method.stages * len(_varying(program)))


def print_step(program: Program, method: ButcherTable, layout: Layout) -> list[str]:
    """Return the lines of one step, loops over lanes included.

    Either in one loop: stage by stage, and in each the state first, then one tangent vector after the other. Or, in a
    layout with scratch rows, in a loop for the state, which leaves there what the Jacobian is at each stage, and a
    loop that is run through once for each tangent vector.
    """
    dimension, varying = layout.dimension, _varying(program)
    out = Lines(layout)
    out.load("w", range(dimension if layout.scratch else layout.stretch_row))
    if layout.trace:
        out.load("w", [layout.trace_row])
    coefficients = range(layout.coefficient_row, layout.scratch_row)
    out.load("c", coefficients, layout.coefficient_row)
    out.load("phase", range(layout.phase_row, layout.coefficient_row), layout.phase_row)
    joint = range(0 if layout.scratch else layout.vectors)
    state, *frame = [
        _Rows(out, method, range(k * dimension, (k + 1) * dimension)) for k in (0, *(k + 1 for k in joint))
    ]
    trace = _Rows(out, method, range(layout.trace_row, layout.trace_row + layout.trace))
    needed = program.needed([*program.rhs, *(varying if layout.exponents else [])], program.coefficients)
    diagonal = [program.jacobian[i][i] for i in range(dimension)]
    for stage in range(method.stages):
        clock = {TIME: _print_time(out, program, method, stage)} if program.forced else {}
        names = _print_derivatives(out, program, needed, state.values(stage), stage, clock)
        state.take(stage, [["+ " + _print_ref(ref, names)] for ref in program.rhs])
        trace.take(stage, [[f"+ {_print_ref(entry, names)}" for entry in diagonal] for _ in trace.rows])
        for vector in frame:
            vector.take(stage, _print_products(program, vector.values(stage), names))
        if layout.scratch:
            for number, entry in enumerate(varying):
                out.store(layout.scratch_row + stage * len(varying) + number, names[entry])
    for rows in (state, trace, *frame):
        rows.finish()
    if program.forced:
        out.store(layout.phase_row, _print_later(program, 1 / method.unit))
    if not layout.scratch:
        return out.loop()
    inner = Lines(layout)
    inner.load("c", coefficients, layout.coefficient_row)
    first = range(dimension, 2 * dimension)
    inner.load("w", first, offset="o")
    vector = _Rows(inner, method, first, "o")
    names = {name: f"c{m}" for m, name in enumerate(program.coefficients)}
    for stage in range(method.stages):
        row = layout.scratch_row + stage * len(varying)
        inner.load(f"j{stage}_", range(row, row + len(varying)), row)
        names |= {entry: f"j{stage}_{number}" for number, entry in enumerate(varying)}
        vector.take(stage, _print_products(program, vector.values(stage), names))
    vector.finish()
    loop = [f"    o = k * {dimension * layout.lanes}", *("    " + line for line in inner.loop())]
    return [*out.loop(), f"for k in range({layout.vectors}):", *loop]


class _Rows:
    """The way of a vector's rows through the stages of a step.

    Their sums are kept in units of the last weight, w + b_S (sum_i (b_i / b_S) k_i), for then the last derivative of
    a tangent vector can start from it: 12 operations less for RK4 with three vectors.
    """

    def __init__(self, out: Lines, method: ButcherTable, rows: Sequence[int], offset: str = "") -> None:
        self.rows = rows
        self._out, self._method, self._offset = out, method, offset
        self._sums = dict.fromkeys(rows, "")

    def values(self, stage: int) -> list[str]:
        """Print the rows' values at a stage and return their names."""
        return [_print_stage(self._out, self._method, stage, row) for row in self.rows]

    def take(self, stage: int, slopes: Iterable[list[str]]) -> None:
        """Print the rows' derivatives at a stage, given as signed terms, and what they add to the sums."""
        last = stage == self._method.stages - 1
        for row, slope in zip(self.rows, slopes, strict=True):
            total = self._sums[row]
            start = [f"+ {total}"] if last and total else []
            self._out.let(f"k{stage}_{row}", " ".join([*start, *slope]).removeprefix("+ "))
            if not last:
                self._sums[row] = _print_sum(self._out, self._method, stage, row, total)

    def finish(self) -> None:
        """Print the rows' values at the end of the step."""
        weight = self._method.b[-1] / self._method.unit
        for row in self.rows:
            self._out.store(row, f"w{row} {_print_term(weight, f'k{self._method.stages - 1}_{row}')}", self._offset)


def _varying(program: Program) -> list[str]:
    """Return the entries of the Jacobian that depend on the state, each once."""
    constant = set(program.coefficients)
    entries = (entry for row in program.jacobian for entry in row if isinstance(entry, str))
    return [entry for entry in dict.fromkeys(entries) if entry not in constant]


def _print_time(out: Lines, program: Program, method: ButcherTable, stage: int) -> str:
    """Print the time of a stage and return its name."""
    if not method.nodes[stage]:
        return "phase0"
    out.let(f"phase{stage}", _print_later(program, method.nodes[stage] / method.unit))
    return f"phase{stage}"


def _print_later(program: Program, factor: Fraction | float) -> str:
    """Print the time so many units of time after the start of the step."""
    return f"phase0 {_print_term(factor, f'c{program.coefficients.index(TIME_SCALE)}')}"


def _print_derivatives(
    out: Lines,
    program: Program,
    needed: Iterable[Assignment],
    y: Iterable[str],
    stage: int,
    clock: Mapping[str, str],
) -> dict[str, str]:
    """Print what the derivatives at the state `y` need; return what each name of the program is called there.

    Coefficients are rows of their own, so nothing that only they depend on is printed. `clock` is the time, if any.
    """
    names = {name: f"c{m}" for m, name in enumerate(program.coefficients)} | dict(zip(program.states, y, strict=True))
    names |= clock
    for assignment in needed:
        names[assignment.target] = f"{assignment.target}_{stage}"
        out.let(names[assignment.target], _print_assignment(assignment, names))
    return names


def _print_sum(out: Lines, method: ButcherTable, stage: int, row: int, total: str) -> str:
    """Print what a stage's derivative adds to the weighted sum of a row and return the sum's name.

    Derivatives of equal weight are added up before they are multiplied: an addition does not compete for the units
    that multiply (9.0 -> 8.4 ns per step).
    """
    weight = method.b[stage]
    if not weight:
        return total
    same = [i for i in range(method.stages - 1) if method.b[i] == weight]
    term = f"k{stage}_{row}"
    if stage > same[0]:
        before = same[same.index(stage) - 1]
        out.let(f"z{stage}_{row}", f"{'k' if before == same[0] else 'z'}{before}_{row} + {term}")
        term = f"z{stage}_{row}"
    if stage < same[-1]:
        return total
    out.let(f"x{stage}_{row}", f"{total} {_print_term(weight / method.b[-1], term)}".removeprefix(" + "))
    return f"x{stage}_{row}"


def _print_stage(out: Lines, method: ButcherTable, stage: int, row: int) -> str:
    """Print the value of a row at a stage and return its name."""
    terms = [_print_term(x / method.unit, f"k{j}_{row}") for j, x in enumerate(method.a[stage]) if x]
    if not terms:
        return f"w{row}"
    out.let(f"y{stage}_{row}", " ".join([f"w{row}", *terms]))
    return f"y{stage}_{row}"


def _print_term(factor: Fraction | float, value: str) -> str:
    """Print a signed multiple of a value, without multiplying by one."""
    sign, size = "-" if factor < 0 else "+", abs(float(factor))
    return f"{sign} {value}" if size == 1.0 else f"{sign} {size!r} * {value}"


def _print_products(program: Program, vector: Sequence[str], names: Mapping[str, str]) -> list[list[str]]:
    """Return the signed terms of the Jacobian times a vector, row by row, without zeros and ones."""
    return [
        [_print_product(entry, v, names) for entry, v in zip(row, vector, strict=True) if entry != 0.0] or ["+ 0.0"]
        for row in program.jacobian
    ]


def _print_product(entry: Ref, value: str, names: Mapping[str, str]) -> str:
    if isinstance(entry, float) and abs(entry) == 1.0:
        return f"{'-' if entry < 0 else '+'} {value}"
    return f"+ {_print_ref(entry, names)} * {value}"


def _print_assignment(assignment: Assignment, names: Mapping[str, str]) -> str:
    arguments = [_print_ref(ref, names) for ref in assignment.arguments]
    if assignment.operation in _SYMBOLS:
        return f" {_SYMBOLS[assignment.operation]} ".join(arguments)
    if assignment.operation in _RELATIONS:
        left, right, first, second = arguments
        return f"select({left} {_RELATIONS[assignment.operation]} {right}, {first}, {second})"
    return f"-{arguments[0]}" if assignment.operation == "neg" else f"{assignment.operation}({arguments[0]})"


def _print_ref(ref: Ref, names: Mapping[str, str]) -> str:
    return names[ref] if isinstance(ref, str) else f"({ref!r})"
