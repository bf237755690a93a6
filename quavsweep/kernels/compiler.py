"""Compiling printed sources with numba."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from collections.abc import Callable
from functools import cache
from typing import Any

from quavsweep.kernels.cache import cache_folder, write_once
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.printer import print_kernel
from quavsweep.kernels.program import Program


def default_lanes() -> int:
    """Return the number of lanes, which is never chosen by a clock: two AVX-512 registers, four of AVX2."""
    return 16


def make_advance(program: Program, method: ButcherTable, layout: Layout, dense: bool = False) -> Callable[..., None]:
    """Return the compiled `advance(lanes, first, last, n_blocks, block)`, or `record` if dense; see `print_kernel`.

    The source file is named by the hash of its content, so numba's disk cache, which looks at one file only, is safe.
    """
    return _load(print_kernel(program, method, layout, dense), "record" if dense else "advance")


@cache
def _load(source: str, function: str) -> Callable[..., None]:
    digest = hashlib.sha256(source.encode()).hexdigest()
    name = f"kernel_{digest[:32]}"
    path = cache_folder() / f"{name}.py"
    write_once(path, source)
    spec = importlib.util.spec_from_file_location(f"quavsweep_cache.{name}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except Exception:
        # Machine code in the cache that cannot be loaded is made again; an error that remains is a real one.
        for stale in path.parent.glob(f"__pycache__/{name}*"):
            stale.unlink(missing_ok=True)
        spec.loader.exec_module(module)
    compiled: Callable[..., None] = getattr(module, function)
    return compiled


def assembly(advance: Any) -> str:
    """Return the machine code of a compiled kernel as text."""
    return str(next(iter(advance.inspect_asm().values())))
