"""The program of a model: from the cache if its equations have been derived before, derived otherwise."""

from __future__ import annotations

import hashlib
import inspect
from importlib.metadata import version
from typing import TYPE_CHECKING

from quavsweep.kernels.cache import cache_folder, write_once
from quavsweep.kernels.described import DescribedModel
from quavsweep.kernels.program import Program
from quavsweep.kernels.syntax import syntax_digest

if TYPE_CHECKING:
    from quavsweep.models import Model


def make_program(model: Model) -> Program:
    """Return the program of a model; SymPy is imported only if it has to be derived.

    Raises
    ------
    ModelError
        If the equations cannot be compiled.
    """
    if isinstance(model, DescribedModel) and model.program is not None:
        return model.program
    key = _key(model)
    if key is None:
        return _derived(model)
    path = cache_folder() / f"program_{key[:32]}.json"
    try:
        return Program.from_json(path.read_text())
    except (OSError, ValueError, TypeError, KeyError):
        program = _derived(model)
        write_once(path, program.to_json())
        return program


def _derived(model: Model) -> Program:
    from quavsweep.kernels.derive import derive

    return derive(model)


def _key(model: Model) -> str | None:
    """Return what a model's program depends on as a digest; None if the source of its functions is not to be had."""
    try:
        sources = _sources(model)
    except (OSError, TypeError, ValueError):
        return None
    parts = (
        *sources,
        *model.state_names,
        *model.parameter_names,
        syntax_digest("quavsweep.models.function"),
        syntax_digest("quavsweep.kernels.derive"),
        syntax_digest("quavsweep.kernels.choice"),
        syntax_digest("quavsweep.kernels.program"),
        version("sympy"),
    )
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _sources(model: Model) -> tuple[str, ...]:
    return (
        # The whole module, because equations may read its constants and call its helpers, and what a closure holds.
        syntax_digest(model.rhs),
        syntax_digest(model.rhs.__module__),
        repr(inspect.getclosurevars(model.rhs).nonlocals),
        "forced" if model.forcing_period else "",
        syntax_digest(model.forcing_period.__module__) if model.forcing_period else "",
    )
