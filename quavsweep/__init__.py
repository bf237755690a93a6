"""quavsweep: a JIT-compiled parameter-sweep engine for nonlinear dynamics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from quavsweep.analysis.bifurcation import Bifurcation, find_bifurcations
    from quavsweep.analysis.bifurcation_curve import bifurcation_curve
    from quavsweep.analysis.equilibrium_search import Equilibria, find_equilibria
    from quavsweep.cli.progress import show_progress
    from quavsweep.config import Sweep, load_sweep, parse_sweep
    from quavsweep.difference import Difference, compare_results
    from quavsweep.margin import Margin, find_margin
    from quavsweep.plot import draw, draw_point, make_figure, make_point_figure
    from quavsweep.point import Point, compute_point
    from quavsweep.result import Result, open_result
    from quavsweep.sweep import extend_sweep, reclassify, run_sweep

_HOMES = {
    "Bifurcation": "quavsweep.analysis.bifurcation",
    "Difference": "quavsweep.difference",
    "Equilibria": "quavsweep.analysis.equilibrium_search",
    "Point": "quavsweep.point",
    "Result": "quavsweep.result",
    "Sweep": "quavsweep.config",
    "bifurcation_curve": "quavsweep.analysis.bifurcation_curve",
    "compare_results": "quavsweep.difference",
    "compute_point": "quavsweep.point",
    "Margin": "quavsweep.margin",
    "draw": "quavsweep.plot",
    "find_margin": "quavsweep.margin",
    "draw_point": "quavsweep.plot",
    "find_bifurcations": "quavsweep.analysis.bifurcation",
    "find_equilibria": "quavsweep.analysis.equilibrium_search",
    "load_sweep": "quavsweep.config",
    "make_figure": "quavsweep.plot",
    "make_point_figure": "quavsweep.plot",
    "open_result": "quavsweep.result",
    "parse_sweep": "quavsweep.config",
    "extend_sweep": "quavsweep.sweep",
    "reclassify": "quavsweep.sweep",
    "run_sweep": "quavsweep.sweep",
    "show_progress": "quavsweep.cli.progress",
}

__all__ = [
    "Bifurcation",
    "Difference",
    "Equilibria",
    "Margin",
    "Point",
    "Result",
    "Sweep",
    "__version__",
    "bifurcation_curve",
    "compare_results",
    "compute_point",
    "draw",
    "draw_point",
    "extend_sweep",
    "find_bifurcations",
    "find_equilibria",
    "find_margin",
    "load_sweep",
    "make_figure",
    "make_point_figure",
    "open_result",
    "parse_sweep",
    "reclassify",
    "run_sweep",
    "show_progress",
]


def __dir__() -> list[str]:
    """Return the public names, for completion."""
    return __all__


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used, so that importing the package costs nothing."""
    if name in _HOMES:
        from importlib import import_module

        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
