"""Naive twins of the kernels: one cell at a time, in plain Python, from the model's own function."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from quavsweep.kernels.method import RK4, ButcherTable
from quavsweep.models import Model

TINY = 1e-30  # step of the complex step derivative; its error is of the order of its square


def rhs(model: Model, u: Sequence[float], p: Sequence[float], t: float = 0.0) -> list[float]:
    return list(model.field(u, p, t))


def tangent(model: Model, u: Sequence[float], q: Sequence[float], p: Sequence[float], t: float = 0.0) -> list[float]:
    """Return the Jacobian times a vector by a complex step."""
    moved = [complex(x, TINY * v) for x, v in zip(u, q, strict=True)]
    return [complex(f).imag / TINY for f in model.field(moved, p, t)]


def step(
    model: Model,
    u: list[float],
    frame: list[list[float]],
    p: Sequence[float],
    dt: float,
    method: ButcherTable = RK4,
    t: float = 0.0,
) -> tuple[list[float], list[list[float]]]:
    """Return state and tangent vectors after one step, by the table as textbooks write it."""
    start, slopes = [u, *frame], []
    for row in method.a:
        y, *w = [_moved(x, [k[m] for k in slopes], row, dt) for m, x in enumerate(start)]
        now = t + dt * sum(map(float, row))
        slopes.append([rhs(model, y, p, now), *(tangent(model, y, q, p, now) for q in w)])
    first, *rest = [_moved(x, [k[m] for k in slopes], method.b, dt) for m, x in enumerate(start)]
    return first, rest


def _moved(
    x: Sequence[float], slopes: Sequence[Sequence[float]], weights: Sequence[Fraction | float], dt: float
) -> list[float]:
    return [
        value + dt * sum(float(w) * k[i] for w, k in zip(weights, slopes, strict=True)) for i, value in enumerate(x)
    ]


def gram_schmidt(frame: list[list[float]]) -> tuple[list[list[float]], list[float]]:
    """Return orthonormal vectors and the stretching factors."""
    done: list[list[float]] = []
    factors = []
    for vector in frame:
        rest = list(vector)
        for e in done:
            d = sum(a * b for a, b in zip(rest, e, strict=True))
            rest = [a - d * b for a, b in zip(rest, e, strict=True)]
        size = math.sqrt(sum(a * a for a in rest))
        done.append([a / size for a in rest])
        factors.append(size)
    return done, factors


def lyapunov(
    model: Model, u: list[float], frame: list[list[float]], p: Sequence[float], dt: float, steps: int, block: int
) -> tuple[list[float], list[float]]:
    """Return the final state and the growth of ln of each vector after so many steps."""
    growth = [0.0] * len(frame)
    for n in range(1, steps + 1):
        u, frame = step(model, u, frame, p, dt, t=(n - 1) * dt)
        if n % block == 0:
            frame, factors = gram_schmidt(frame)
            growth = [g + math.log(f) for g, f in zip(growth, factors, strict=True)]
    return u, growth
