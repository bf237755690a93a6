"""The program of a model: from the cache if its equations have been derived before, derived otherwise."""

from __future__ import annotations

import hashlib
import inspect
from importlib.metadata import version
from typing import TYPE_CHECKING

from quavsweep.kernels.cache import cache_folder, write_once
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
    parts = (
        # The whole module, because equations may read its constants and call its helpers, and what a closure holds.
        syntax_digest(model.rhs),
        syntax_digest(model.rhs.__module__),
        repr(inspect.getclosurevars(model.rhs).nonlocals),
        *model.state_names,
        *model.parameter_names,
        syntax_digest(model.forcing_period) if model.forcing_period else "",
        syntax_digest("quavsweep.models.function"),
        syntax_digest("quavsweep.kernels.derive"),
        syntax_digest("quavsweep.kernels.choice"),
        syntax_digest("quavsweep.kernels.program"),
        version("sympy"),
    )
    key = hashlib.sha256("\n".join(parts).encode()).hexdigest()
    path = cache_folder() / f"program_{key[:32]}.json"
    try:
        return Program.from_json(path.read_text())
    except (OSError, ValueError, TypeError, KeyError):
        from quavsweep.kernels.derive import derive

        program = derive(model)
        write_once(path, program.to_json())
        return program
