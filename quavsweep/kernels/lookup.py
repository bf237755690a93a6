"""The programs of a model, of its equations and its observables: from the cache, or derived if they are new."""

from __future__ import annotations

import hashlib
import inspect
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from quavsweep.errors import ModelError
from quavsweep.kernels.cache import cache_folder, read_sealed, write_sealed
from quavsweep.kernels.described import DescribedModel
from quavsweep.kernels.installed import installed_version
from quavsweep.kernels.program import Program
from quavsweep.kernels.syntax import syntax_digest

if TYPE_CHECKING:
    from quavsweep.models import Model

_MODELS = "quavsweep.models."


def make_program(model: Model) -> Program:
    """Return the program of a model; SymPy is imported only if it has to be derived.

    Raises
    ------
    ModelError
        If the equations cannot be compiled.
    """
    if isinstance(model, DescribedModel) and model.program is not None:
        return model.program

    def derived() -> Program:
        from quavsweep.kernels.derive import derive

        return derive(model)

    return _cached("program", _key(model, _sources), derived)


def make_observables(model: Model) -> Program:
    """Return the program of a model's observables: `rhs` has their values, then their rates of change along orbits.

    Raises
    ------
    ModelError
        If an observable cannot be compiled.
    """
    if isinstance(model, DescribedModel) and model.observed is not None:
        return model.observed
    if not model.observables:
        states, parameters = (f"u_{n}" for n in model.state_names), (f"p_{n}" for n in model.parameter_names)
        return Program(tuple(states), tuple(parameters), (), (), (), (), ())

    def derived() -> Program:
        from quavsweep.kernels.derive import derive_observables

        return derive_observables(model)

    return _cached("observables", _key(model, _observed_sources), derived)


def program_key(model: Model) -> str:
    """Return a digest of all that the program of a model depends on, empty if that is not to be had."""
    return _key(model, _sources) or ""


def keep_program(model: Model, key: str, text: str) -> None:
    """Keep the program of a model as another process has it, so that it need not be derived here.

    Only where the equations are the same here: one under another `program_key` is left alone.
    """
    if key and key == program_key(model):
        path = cache_folder() / f"program_{key[:32]}.json"
        if not path.exists():
            write_sealed(path, Program.from_json(text).to_json())


def _cached(kind: str, key: str | None, derived: Callable[[], Program]) -> Program:
    """Return the program of that key, derived if there is none."""
    if key is None:
        return derived()
    path = cache_folder() / f"{kind}_{key[:32]}.json"
    try:
        return Program.from_json(read_sealed(path))
    except (OSError, ValueError, TypeError, KeyError):
        program = derived()
        write_sealed(path, program.to_json())
        return program


def _key(model: Model, sources_of: Callable[[Model], tuple[str, ...]]) -> str | None:
    """Return what a program depends on as a digest; None if that is not to be had.

    A model of this package depends on its sources. Any other one may take its numbers from wherever it likes, other
    files, data, what was typed before; only what its functions return for symbols tells them all.
    """
    try:
        sources = sources_of(model) if _is_ours(model) else _returned(model)
    except (ModelError, OSError, RecursionError, TypeError, ValueError):
        return None
    parts = (
        *sources,
        *model.state_names,
        *model.parameter_names,
        syntax_digest("quavsweep.models.function"),
        syntax_digest("quavsweep.kernels.derive"),
        syntax_digest("quavsweep.kernels.choice"),
        syntax_digest("quavsweep.kernels.program"),
        installed_version("sympy"),
    )
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _is_ours(model: Model) -> bool:
    """Whether all functions of a model are of this package."""
    functions = [model.rhs, model.forcing_period, *(observable.function for observable in model.observables)]
    return all(str(getattr(f, "__module__", "")).startswith(_MODELS) for f in functions if f is not None)


def _returned(model: Model) -> tuple[str, ...]:
    """Return what all functions of a model return for symbols."""
    from quavsweep.kernels.derive import returned

    return ("symbols", *returned(model))


def _sources(model: Model) -> tuple[str, ...]:
    return (
        *_source(model.rhs),
        "forced" if model.forcing_period else "",
        syntax_digest(model.forcing_period.__module__) if model.forcing_period else "",
    )


def _observed_sources(model: Model) -> tuple[str, ...]:
    observed = ((o.name, str(o.component), *_source(o.function)) for o in model.observables)
    return (*_sources(model), *(part for parts in observed for part in parts))


def _source(function: Callable[..., Any]) -> tuple[str, ...]:
    """Return digests of all that a function's value may depend on."""
    return (
        # The whole module, because functions may read its constants and call its helpers, and what a closure holds.
        syntax_digest(function),
        syntax_digest(function.__module__),
        repr(inspect.getclosurevars(function).nonlocals),
        *(syntax_digest(name) for name in sorted(_shared(function.__module__) - {function.__module__})),
    )


def _shared(module: str) -> set[str]:
    """Return the modules of this package's models from which a module takes functions, and those from which they do."""
    found: set[str] = set()
    todo = [module]
    while todo:
        values = vars(sys.modules[todo.pop()]).values() if todo[-1] in sys.modules else ()
        names = {value.__name__ if inspect.ismodule(value) else getattr(value, "__module__", "") for value in values}
        new = {name for name in names if str(name).startswith(_MODELS)} - found
        found |= new
        todo += sorted(new)
    return found
