"""Identities of evidence, toolchain and result, and what is known of the machine."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import quavsweep
from quavsweep.config import Sweep
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.printer import print_kernel
from quavsweep.kernels.syntax import syntax_digest

HASHED_MODULES = (
    "quavsweep.integrate",
    "quavsweep.measures",
    "quavsweep.analysis.certificate",
    "quavsweep.analysis.equilibrium",
    "quavsweep.analysis.interval",
    "quavsweep.kernels.program",
)
_NO_EVIDENCE = ("name", "classify", "integrate.duration")  # keys that change no integrated number


def digest(data: Any) -> str:
    """Return a short SHA-256 of data that JSON can hold."""
    return hashlib.sha256(json.dumps(data, sort_keys=True, separators=(",", ":")).encode()).hexdigest()[:32]


def flatten(data: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested keys as dotted ones."""
    flat: dict[str, Any] = {}
    for key, value in data.items():
        flat |= flatten(value, f"{prefix}{key}.") if isinstance(value, dict) and value else {f"{prefix}{key}": value}
    return flat


def evidence_parts(sweep: Sweep) -> dict[str, Any]:
    """Return all that changes an integrated number, by name: config, equations, kernel, tile loop."""
    program = make_program(sweep.model)
    layout = Layout(program.dimension, sweep.measures.vectors, len(program.coefficients))
    kept = {k: v for k, v in flatten(sweep.canonical()).items() if not k.startswith(_NO_EVIDENCE)}
    axes = {axis.name: [value.hex() for value in axis.values] for axis in sweep.grid.axes}
    return {
        **{f"config.{key}": value for key, value in kept.items()},
        "axes": digest(axes),
        "axes.order": list(axes),
        "model.bound": sweep.model.bound,
        "equations": program.digest,
        "kernel": digest(print_kernel(program, sweep.method, layout)),
        **{f"engine.{name}": syntax_digest(name) for name in HASHED_MODULES},
    }


@cache
def toolchain() -> dict[str, str]:
    """Return what else decides the bits of a result: compilers, libraries and instructions of the processor."""
    import llvmlite.binding as llvm
    import numpy as np
    import numpy.linalg  # noqa: F401 - loads the BLAS that is asked for
    from threadpoolctl import threadpool_info

    blas = [info for info in threadpool_info() if info["user_api"] == "blas"]
    features = llvm.get_host_cpu_features()
    return {
        "numba": version("numba"),
        "llvmlite": version("llvmlite"),
        "numpy": version("numpy"),
        "fma": str(bool(features.get("fma"))),
        "simd": " ".join(np.show_config(mode="dicts")["SIMD Extensions"]["found"]),  # type: ignore[index, call-overload]
        "blas": " ".join(sorted({f"{b['internal_api']} {b['version']} {b.get('architecture', '')}" for b in blas})),
    }


def stage(sweep: Sweep) -> str:
    """Return the name of the stage that a sweep covers: its first and last step."""
    return f"0-{sweep.clock.steps}"


def result_id(evidence_id: str, toolchain_id: str, sweep: Sweep) -> str:
    """Return the identity of a result: evidence, stages, thresholds and the rules that use them."""
    rules = syntax_digest("quavsweep.classify")
    thresholds = sweep.config.classify.model_dump()
    return digest([evidence_id, toolchain_id, [stage(sweep)], thresholds, rules])


def machine() -> dict[str, Any]:
    """Return versions and hardware, for the record of a run; never part of a result."""
    packages = ("numpy", "numba", "llvmlite", "h5py", "dask", "matplotlib", "sympy", "pydantic", "ruamel.yaml")
    return {
        "quavsweep": quavsweep.__version__,
        "python": sys.version.split()[0],
        "packages": {name: version(name) for name in packages},
        "system": platform.platform(),
        "processor": _processor(),
        "cores": os.cpu_count(),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
