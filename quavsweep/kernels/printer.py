"""Printing a Program and a method as the source of one compiled function: a step of W lanes in a straight line."""

from __future__ import annotations

from quavsweep.kernels.layout import Layout
from quavsweep.kernels.lower import lower, operations
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.program import Program
from quavsweep.kernels.step import Lines, print_step

# `contract` makes fused multiply-adds. `reassoc` is not needed for speed, because sums are printed in the order that
# fuses best, and without it a state's bits do not depend on what else the step computes. Full fastmath would make
# isfinite(nan) true.
FLAGS = ("contract", "nsz", "arcp")

_HEADER = '''"""Printed by quavsweep; the name of this file is the hash of its content."""

from math import {names}

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

{extra}
@njit("void({types})",
      nogil=True, error_model="numpy", cache=True, fastmath={{{flags}}})
def {signature}:
    align_stack()
'''

# Printed only if used. Selects are instructions, not branches, so a loop with them is vectorised and quickly compiled.
_SELECT = """

@intrinsic
def select(context, condition, first, second):
    def generate(context, builder, signature, arguments):
        return builder.select(*arguments)

    return types.float64(types.boolean, types.float64, types.float64), generate
"""
_BITS = """

@intrinsic
def bits(context, x):
    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def real(context, k):
    def generate(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), generate
"""


def print_kernel(
    program: Program, method: ButcherTable, layout: Layout, dense: bool = False, orthonormal: bool = True
) -> str:
    """Return the source of `advance(lanes, first, last, n_blocks, block)`.

    It advances the groups first .. last - 1 by `n_blocks` blocks of `block` steps, orthonormalises the frame after
    each block and multiplies the stretching factors up. The size of a step lies in the coefficients, which are those
    for the unit of time `method.unit * dt`: a stage of RK4 then adds a derivative instead of multiplying it with dt/2
    (24 of 216 operations leave the units that multiply, 9.4 -> 8.3 ns per step).

    With `dense` it is `record(lanes, first, last, n_blocks, block, buffer)`, which also writes the states before
    the first step and after each into `buffer`, (groups, 1 + steps, D, W) in one dimension. The states are copied by
    a loop of its own behind the step, so the step and its bits are the same.

    Without `orthonormal` the tangent vectors are left as they are, so that they end as the derivative of the last
    state by the first, applied to what they began as.

    The loops over lanes are innermost and their bodies have no branch or call, because only that form is vectorised.
    Everything lies in one array: with two of them LLVM adds a second, scalar loop for the case that they overlap.

    `align_stack` puts a slot that wants 64 bytes on the stack. A step keeps about 40 vectors there, and without such
    a slot LLVM leaves the stack at the caller's 16 bytes: most of those stores and loads then cross a cache line
    (measured: 7.8 ns per step with it, 8 to 13 without, as chance would have it from process to process).
    """
    step = print_step(lower(program), method, layout)
    arguments = ["lanes", "first", "last", "n_blocks", "block", *(["buffer"] if dense else [])]
    types = ["float64[::1]", *["int64"] * 4, *(["float64[::1]"] if dense else [])]
    signature = f"{'record' if dense else 'advance'}({', '.join(arguments)})"
    lines = [_print_header("\n".join(step), ", ".join(types), signature)]
    size = layout.rows * layout.lanes
    lines += [
        "    for group in range(first, last):",
        f"        g = lanes[group * {size} : (group + 1) * {size}]",
        *(_print_copy("(group - first) * (n_blocks * block + 1)", layout, 8) if dense else []),
        "        for _ in range(n_blocks):",
        "            for _ in range(block):",
        *("                " + line for line in step),
        *(_print_copy("at + 1", layout, 16) if dense else []),
    ]
    if layout.vectors and orthonormal:
        lines += ["            " + line for line in _print_gram_schmidt(layout)]
    return "\n".join(lines) + "\n"


def _print_header(step: str, types: str, signature: str) -> str:
    """Print all above the loops: imports and instructions that have no operator only if the step uses them."""
    names = [*(name for name in ("inf", "nan") if f"{name})" in step), "sqrt"]
    extra = (_SELECT if "select(" in step else "") + (_BITS if "bits(" in step else "")
    flags = ", ".join(repr(flag) for flag in FLAGS)
    header = _HEADER.format(flags=flags, types=types, signature=signature, names=", ".join(names), extra=extra)
    return header.rstrip()


def _print_copy(at: str, layout: Layout, indent: int) -> list[str]:
    """Print the copy of the group's states into the buffer, at the number `at` of a state there."""
    size = layout.frame_row * layout.lanes
    lines = [f"at = {at}", f"for i in range({size}):", f"    buffer[at * {size} + i] = g[i]"]
    return [" " * indent + line for line in lines]


def _print_gram_schmidt(layout: Layout) -> list[str]:
    """Print modified Gram-Schmidt over the frame; norms multiply the stretching factors."""
    dimension, out = layout.dimension, Lines(layout)
    out.load("w", range(layout.frame_row, layout.stretch_row))
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
    return out.loop()


def step_operations(program: Program, method: ButcherTable, layout: Layout) -> int:
    """Return the number of arithmetic operations in a step of one cell, a fused multiply-add counted as one.

    A static estimate for cost models: products count, sums are taken to fuse with them; functions count as spelt out.
    """
    program = lower(program)
    rows = layout.dimension * (1 + layout.vectors)
    jacobian = [entry for row in program.jacobian for entry in row] if layout.vectors else []
    stage = operations(program.needed([*program.rhs, *jacobian], program.coefficients))
    stage += layout.vectors * sum(entry != 0.0 for entry in jacobian)
    sums = sum(x != 0 for row in method.a for x in row) + sum(x != 0 for x in method.b) - 1
    return method.stages * stage + rows * sums
