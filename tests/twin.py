"""Naive twins of the kernels: one cell at a time, in plain Python, from the model's own function."""

from __future__ import annotations

import math
from collections.abc import Sequence

from quavsweep.models import Model

TINY = 1e-30  # step of the complex step derivative; its error is of the order of its square


def rhs(model: Model, u: Sequence[float], p: Sequence[float]) -> list[float]:
    return list(model.rhs(*u, *p))


def tangent(model: Model, u: Sequence[float], q: Sequence[float], p: Sequence[float]) -> list[float]:
    """Return the Jacobian times a vector by a complex step."""
    moved = [complex(x, TINY * v) for x, v in zip(u, q, strict=True)]
    return [complex(f).imag / TINY for f in model.rhs(*moved, *p)]


def step(
    model: Model, u: list[float], frame: list[list[float]], p: Sequence[float], dt: float
) -> tuple[list[float], list[list[float]]]:
    """Return state and tangent vectors after one classical step of fourth order."""
    stages = []
    y, w = u, frame
    for c in (0.5, 0.5, 1.0, 0.0):
        slopes = [rhs(model, y, p), *(tangent(model, y, q, p) for q in w)]
        stages.append(slopes)
        y = [x + c * dt * k for x, k in zip(u, slopes[0], strict=True)]
        w = [[x + c * dt * k for x, k in zip(q, s, strict=True)] for q, s in zip(frame, slopes[1:], strict=True)]
    rows = []
    for m, row in enumerate([u, *frame]):
        k1, k2, k3, k4 = (s[m] for s in stages)
        total = [a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
        rows.append([x + dt / 6 * k for x, k in zip(row, total, strict=True)])
    return rows[0], rows[1:]


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
        u, frame = step(model, u, frame, p, dt)
        if n % block == 0:
            frame, factors = gram_schmidt(frame)
            growth = [g + math.log(f) for g, f in zip(growth, factors, strict=True)]
    return u, growth
