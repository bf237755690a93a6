"""quavsweep: a JIT-compiled parameter-sweep engine for nonlinear dynamics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from quavsweep.config import Sweep, load_sweep
    from quavsweep.plot import draw
    from quavsweep.result import Result, open_result
    from quavsweep.sweep import run_sweep

_HOMES = {
    "Sweep": "quavsweep.config",
    "load_sweep": "quavsweep.config",
    "run_sweep": "quavsweep.sweep",
    "Result": "quavsweep.result",
    "open_result": "quavsweep.result",
    "draw": "quavsweep.plot",
}

__all__ = ["Result", "Sweep", "__version__", "draw", "load_sweep", "open_result", "run_sweep"]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used, so that importing the package costs nothing."""
    if name in _HOMES:
        from importlib import import_module

        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
