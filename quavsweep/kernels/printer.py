"""Printing a Program and a method as the source of one compiled function: a step of W lanes in a straight line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

from quavsweep.kernels.layout import Layout
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Assignment, Program, Ref

# `contract` makes fused multiply-adds. `reassoc` is not needed for speed, because sums are printed in the order that
# fuses best, and without it a state's bits do not depend on what else the step computes. Full fastmath would make
# isfinite(nan) true.
FLAGS = ("contract", "nsz", "arcp")

_HEADER = '''"""Printed by quavsweep; the name of this file is the hash of its content."""

from math import sqrt

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic


@intrinsic
def align_stack(context):
    def generate(context, builder, signature, arguments):
        with builder.goto_entry_block():
            slot = builder.alloca(ir.VectorType(ir.DoubleType(), 8))
            slot.align = 64
        builder.asm(ir.FunctionType(ir.VoidType(), [slot.type]), "", "r", [slot], True)
        return context.get_dummy_value()

    return types.void(), generate


@njit("void({types})",
      nogil=True, error_model="numpy", cache=True, fastmath={{{flags}}})
def {signature}:
    align_stack()
'''

_SYMBOLS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}


def print_kernel(program: Program, method: ButcherTable, layout: Layout, dense: bool = False) -> str:
    """Return the source of `advance(lanes, first, last, n_blocks, block)`.

    It advances the groups first .. last - 1 by `n_blocks` blocks of `block` steps, orthonormalises the frame after
    each block and multiplies the stretching factors up. The size of a step lies in the coefficients, which are those
    for the unit of time `method.unit * dt`: a stage of RK4 then adds a derivative instead of multiplying it with dt/2
    (24 of 192 operations less on the units that multiply, 9.1 -> 8.2 ns per step).

    With `dense` it is `record(lanes, first, last, n_blocks, block, buffer)`, which also writes the states before
    the first step and after each into `buffer`, (groups, 1 + steps, D, W) in one dimension. The states are copied by
    a loop of its own behind the step, so the step and its bits are the same.

    The loop over lanes is innermost and its body is one whole step without a branch or a call, because only that
    form is vectorised. Everything lies in one array: with two of them LLVM adds a second, scalar loop for the case
    that they overlap.

    `align_stack` puts a slot that wants 64 bytes on the stack. A step keeps about 40 vectors there, and without such
    a slot LLVM leaves the stack at the caller's 16 bytes: most of those stores and loads then cross a cache line
    (measured: 7.8 ns per step with it, 8 to 13 without, as chance would have it from process to process).
    """
    step = _Lines(layout)
    step.load("w", layout.dimension * (1 + layout.vectors), 0)
    step.load("c", layout.coefficients, layout.coefficient_row)
    _print_step(step, program, method, layout)
    arguments = ["lanes", "first", "last", "n_blocks", "block", *(["buffer"] if dense else [])]
    types = ["float64[::1]", *["int64"] * 4, *(["float64[::1]"] if dense else [])]
    signature = f"{'record' if dense else 'advance'}({', '.join(arguments)})"
    flags = ", ".join(repr(flag) for flag in FLAGS)
    lines = [_HEADER.format(flags=flags, types=", ".join(types), signature=signature).rstrip()]
    size = layout.rows * layout.lanes
    lines += [
        "    for group in range(first, last):",
        f"        g = lanes[group * {size} : (group + 1) * {size}]",
        *(_print_copy("(group - first) * (n_blocks * block + 1)", layout, 8) if dense else []),
        "        for _ in range(n_blocks):",
        "            for _ in range(block):",
        f"                for i in range({layout.lanes}):",
        *("                    " + line for line in step.lines),
        *(_print_copy("at + 1", layout, 16) if dense else []),
    ]
    if layout.vectors:
        frame = _Lines(layout)
        frame.load("w", layout.dimension * (1 + layout.vectors), 0, skip=layout.dimension)
        _print_gram_schmidt(frame, layout)
        lines += [f"            for i in range({layout.lanes}):", *("                " + line for line in frame.lines)]
    return "\n".join(lines) + "\n"


def _print_copy(at: str, layout: Layout, indent: int) -> list[str]:
    """Print the copy of the group's states into the buffer, at the number `at` of a state there."""
    size = layout.frame_row * layout.lanes
    lines = [f"at = {at}", f"for i in range({size}):", f"    buffer[at * {size} + i] = g[i]"]
    return [" " * indent + line for line in lines]


class _Lines:
    """The body of a loop over lanes `i`, reading and writing rows of the group `g`."""

    def __init__(self, layout: Layout) -> None:
        self.lines: list[str] = []
        self._lanes = layout.lanes

    def load(self, name: str, count: int, row: int, skip: int = 0) -> None:
        self.lines += [f"{name}{m} = {self.at(row + m)}" for m in range(skip, count)]

    def store(self, row: int, value: str) -> None:
        self.lines.append(f"{self.at(row)} = {value}")

    def let(self, target: str, value: str) -> None:
        self.lines.append(f"{target} = {value}")

    def at(self, row: int) -> str:
        return f"g[{row * self._lanes} + i]"


def _print_step(out: _Lines, program: Program, method: ButcherTable, layout: Layout) -> None:
    """Print one step: stage by stage, and in each the state first, then one tangent vector after the other.

    A vector's stage value, derivative and weighted sum are printed together, so that few values are alive at a time.
    The sum is kept in units of the last weight, w + b_S (sum_i (b_i / b_S) k_i), for then the last derivative of a
    tangent vector can start from it: 12 operations less for RK4 with three vectors.
    """
    dimension, last = layout.dimension, method.stages - 1
    sums = [""] * dimension * (1 + layout.vectors)
    names: dict[str, str] = {name: f"c{m}" for m, name in enumerate(program.coefficients)}
    jacobian = [entry for row in program.jacobian for entry in row] if layout.vectors else []
    for stage in range(method.stages):
        for k in range(1 + layout.vectors):
            rows = range(k * dimension, (k + 1) * dimension)
            y = [_print_stage(out, method, stage, m) for m in rows]
            if k == 0:
                names |= dict(zip(program.states, y, strict=True))
                # Coefficients are rows of their own, so nothing that only they depend on is printed.
                for assignment in program.needed([*program.rhs, *jacobian], program.coefficients):
                    names[assignment.target] = f"{assignment.target}_{stage}"
                    out.let(names[assignment.target], _print_assignment(assignment, names))
                slopes = [["+ " + _print_ref(ref, names)] for ref in program.rhs]
            else:
                slopes = [_print_product(row, y, names) for row in program.jacobian]
            for m, slope in zip(rows, slopes, strict=True):
                start = [f"+ {sums[m]}"] if stage == last and sums[m] else []
                out.let(f"k{stage}_{m}", " ".join([*start, *slope]).removeprefix("+ "))
                if stage < last:
                    sums[m] = _print_sum(out, method, stage, m, sums[m])
    for m in range(len(sums)):
        out.store(m, f"w{m} {_print_term(method.b[-1] / method.unit, f'k{last}_{m}')}")


def _print_sum(out: _Lines, method: ButcherTable, stage: int, row: int, total: str) -> str:
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


def _print_stage(out: _Lines, method: ButcherTable, stage: int, row: int) -> str:
    """Print the value of a row at a stage and return its name."""
    terms = [_print_term(x / method.unit, f"k{j}_{row}") for j, x in enumerate(method.a[stage]) if x]
    if not terms:
        return f"w{row}"
    out.let(f"y{stage}_{row}", " ".join([f"w{row}", *terms]))
    return f"y{stage}_{row}"


def _print_term(factor: Fraction | float, value: str) -> str:
    """Print a signed multiple of a value, without multiplying by one."""
    sign, size = "-" if factor < 0 else "+", float(abs(factor))
    return f"{sign} {value}" if size == 1.0 else f"{sign} {size!r} * {value}"


def _print_product(row: Iterable[Ref], vector: list[str], names: Mapping[str, str]) -> list[str]:
    """Return the signed terms of the product of a row of the Jacobian with a vector, without zeros and ones."""
    terms = []
    for entry, v in zip(row, vector, strict=True):
        if entry == -1.0:
            terms.append(f"- {v}")
        elif entry != 0.0:
            terms.append(f"+ {v}" if entry == 1.0 else f"+ {_print_ref(entry, names)} * {v}")
    return terms or ["+ 0.0"]


def _print_gram_schmidt(out: _Lines, layout: Layout) -> None:
    """Print modified Gram-Schmidt over the frame; norms multiply the stretching factors."""
    dimension = layout.dimension
    for k in range(layout.vectors):
        q = [f"w{(k + 1) * dimension + i}" for i in range(dimension)]
        for j in range(k):
            e = [f"e{j}_{i}" for i in range(dimension)]
            out.let("d", " + ".join(f"{x} * {y}" for x, y in zip(q, e, strict=True)))
            for x, y in zip(q, e, strict=True):
                out.let(x, f"{x} - d * {y}")
        out.let("n", f"sqrt({' + '.join(f'{x} * {x}' for x in q)})")
        out.let("v", "1.0 / n")
        for i, x in enumerate(q):
            out.let(f"e{k}_{i}", f"v * {x}")
            out.store((k + 1) * dimension + i, f"e{k}_{i}")
        row = layout.stretch_row + k
        out.store(row, f"{out.at(row)} * n")


def _print_assignment(assignment: Assignment, names: Mapping[str, str]) -> str:
    arguments = [_print_ref(ref, names) for ref in assignment.arguments]
    if assignment.operation in _SYMBOLS:
        return f" {_SYMBOLS[assignment.operation]} ".join(arguments)
    return f"-{arguments[0]}" if assignment.operation == "neg" else f"sqrt({arguments[0]})"


def _print_ref(ref: Ref, names: Mapping[str, str]) -> str:
    return names[ref] if isinstance(ref, str) else f"({ref!r})"


def step_operations(program: Program, method: ButcherTable, layout: Layout) -> int:
    """Return the number of arithmetic operations in a step of one cell, a fused multiply-add counted as one.

    A static estimate for cost models: products count, sums are taken to fuse with them.
    """
    rows = layout.dimension * (1 + layout.vectors)
    jacobian = [entry for row in program.jacobian for entry in row] if layout.vectors else []
    stage = len(program.needed([*program.rhs, *jacobian], program.coefficients))
    stage += layout.vectors * sum(entry != 0.0 for entry in jacobian)
    sums = sum(x != 0 for row in method.a for x in row) + sum(x != 0 for x in method.b) - 1
    return method.stages * stage + rows * sums
