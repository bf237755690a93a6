"""A linear system in three dimensions: a complex pair of eigenvalues, a real one, and a coupling between them."""

from __future__ import annotations

from typing import Any

from quavsweep.models.model import Example, Model
from quavsweep.models.quantity import Parameter, State


def rhs(x, y, z, re, im, a, k) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
    """Derivatives; the eigenvalues are re +- i im and a, whatever k is. The matrix is normal only for k = 0."""
    return re * x - im * y + k * z, im * x + re * y + k * z, a * z


MODEL = Model(
    name="linear",
    rhs=rhs,
    states=(State("x"), State("y"), State("z")),
    parameters=(
        Parameter("re", -0.2, "1", r"\mathrm{Re}", "real part of the pair"),
        Parameter("im", 1.0, "1", r"\mathrm{Im}", "imaginary part of the pair"),
        Parameter("a", -0.5, "1", "a", "real eigenvalue"),
        Parameter("k", 3.0, "1", "k", "coupling, which makes the eigenvectors oblique"),
    ),
    symmetries=((-1, -1, -1),),
    source="closed form: the exponents are the real parts of the eigenvalues",
    example=Example(
        initial={"x": 1.0, "y": 1.0, "z": 1.0},
        axes={"re": (-1.0, 0.1, 12), "a": (-1.0, 0.1, 12)},
        dt=0.02,
        transient=100.0,
        duration=400.0,
    ),
)
