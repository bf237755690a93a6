"""Compiling printed sources with numba."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from quavsweep.kernels.cache import (
    cache_folder,
    check_machine_code,
    discard_machine_code,
    seal_machine_code,
    write_once,
)
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.printer import print_kernel
from quavsweep.kernels.program import Program

# Lanes per group, W, by the class of the processor. Measured on Zen 4, ns per step of the yaw system with three
# vectors (spread of 9 samples about 0.5), the second row with the instructions of AVX2 only:
#   W          16     24     32     64
#   AVX-512   7.7    8.0    8.2    8.1
#   AVX2     11.4   11.1   10.4   11.2
# No W is faster beyond the spread, and the smallest wastes the fewest lanes where cells end early.
LANES = {"AVX-512": 16, "AVX2": 16, "other": 16}


def cpu_class() -> str:
    """Return the widest vectors that the processor has, a key of `LANES`."""
    with contextlib.suppress(OSError):
        flags = set(Path("/proc/cpuinfo").read_text().partition("flags")[2].partition("\n")[0].split())
        return "AVX-512" if "avx512f" in flags else "AVX2" if "avx2" in flags else "other"
    return "other"


def default_lanes() -> int:
    """Return the number of lanes for this processor, which is never chosen by a clock; results do not depend on it."""
    return LANES[cpu_class()]


def make_advance(
    program: Program, method: ButcherTable, layout: Layout, dense: bool = False, orthonormal: bool = True
) -> Callable[..., None]:
    """Return the compiled `advance(lanes, first, last, n_blocks, block)`, or `record` if dense; see `print_kernel`.

    The source file is named by the hash of its content, so numba's disk cache, which looks at one file only, is safe.
    """
    return _load(print_kernel(program, method, layout, dense, orthonormal), "record" if dense else "advance")


@cache
def _load(source: str, function: str) -> Callable[..., None]:
    digest = hashlib.sha256(source.encode()).hexdigest()
    name = f"kernel_{digest[:32]}"
    path = cache_folder() / f"{name}.py"
    write_once(path, source)
    check_machine_code(path)
    spec = importlib.util.spec_from_file_location(f"quavsweep_cache.{name}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except Exception:
        # Machine code in the cache that cannot be loaded is made again; an error that remains is a real one.
        discard_machine_code(path)
        spec.loader.exec_module(module)
    seal_machine_code(path)
    compiled: Callable[..., None] = getattr(module, function)
    return compiled


def assembly(advance: Any) -> str:
    """Return the machine code of a compiled kernel as text."""
    return str(next(iter(advance.inspect_asm().values())))
