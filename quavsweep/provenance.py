"""Identities of evidence, toolchain and result, and what is known of the machine."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import quavsweep
from quavsweep.config import Sweep
from quavsweep.kernels.installed import installed_version
from quavsweep.kernels.layout import FEWEST_LANES
from quavsweep.kernels.lookup import make_observables, make_program
from quavsweep.kernels.printer import print_kernel
from quavsweep.kernels.step import choose_layout
from quavsweep.kernels.syntax import syntax_digest

HASHED_MODULES = (
    "quavsweep.integrate",
    "quavsweep.look",
    "quavsweep.plan",
    "quavsweep.clock",
    "quavsweep.codes",
    "quavsweep.grid",
    "quavsweep.measures",
    "quavsweep.measures.lyapunov",
    "quavsweep.measures.measure",
    "quavsweep.measures.variable",
    "quavsweep.measures.verdict",
    "quavsweep.analysis.certificate",
    "quavsweep.analysis.cycle",
    "quavsweep.analysis.equilibrium",
    "quavsweep.analysis.event",
    "quavsweep.analysis.floquet",
    "quavsweep.analysis.flow",
    "quavsweep.analysis.interval",
    "quavsweep.analysis.kink",
    "quavsweep.analysis.own_cycle",
    "quavsweep.analysis.returns",
    "quavsweep.analysis.shooting",
    "quavsweep.analysis.tour",
    "quavsweep.analysis.tube",
    "quavsweep.kernels.formula",
    "quavsweep.kernels.layout",
    "quavsweep.kernels.method",
    "quavsweep.kernels.minimax",
    "quavsweep.kernels.program",
    "quavsweep.kernels.step",
)
DENSE_MODULES = (
    "quavsweep.measures.dense",
    "quavsweep.measures.statistics",
    "quavsweep.analysis.crossing",
    "quavsweep.analysis.domain",
    "quavsweep.analysis.observer",
    "quavsweep.analysis.scene",
    "quavsweep.analysis.standard_error",
    "quavsweep.analysis.statistics",
)
_NUMBA_SETTINGS = ("NUMBA_OPT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_LOOP_VECTORIZE", "NUMBA_SLP_VECTORIZE")
CLASSIFY_MODULES = (
    "quavsweep.analysis.birkhoff",
    "quavsweep.analysis.change_point",
    "quavsweep.analysis.exact",
    "quavsweep.analysis.standard_error",
    "quavsweep.classify",
    "quavsweep.classify.chaotic_phase",
    "quavsweep.classify.growth",
    "quavsweep.classify.region",
    "quavsweep.classify.self_check",
    "quavsweep.classify.sign",
    "quavsweep.classify.variable",
    "quavsweep.classify.window",
    "quavsweep.codes",
    "quavsweep.content",
)
RESULT_MODULES = (
    *CLASSIFY_MODULES,
    "quavsweep.analysis.attractor",
    "quavsweep.analysis.lifetime",
    "quavsweep.passes",
    "quavsweep.reduction",
    "quavsweep.store.netcdf",
    "quavsweep.store.outcome",
)
_NO_EVIDENCE = ("classify", "integrate.duration", "effort", "evidence")  # keys that change no integrated number


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
    """Return all that changes what is in shards, by name: config, equations, kernel, tile loop.

    Where no evidence is kept, that is what the classification makes of it, so thresholds, their code and the end count.
    """
    program = make_program(sweep.model)
    layout = choose_layout(program, sweep.method, sweep.measures.vectors, FEWEST_LANES, sweep.measures.trace)
    told = () if sweep.keeps_evidence else CLASSIFY_MODULES
    modules = (*HASHED_MODULES, *(DENSE_MODULES if sweep.dense else ()), *told)
    free = _NO_EVIDENCE if sweep.keeps_evidence else ()
    kept = {k: v for k, v in flatten(sweep.settings()).items() if not k.startswith(free)}
    axes = _axes(sweep)
    return {
        **{f"config.{key}": value for key, value in kept.items()},
        "axes": digest(axes),
        "axes.order": list(axes),
        "model.bound": sweep.model.bound,
        "model.circles": [state.circle for state in sweep.model.states],
        "model.section": repr(sweep.model.section),
        "model.symmetries": [list(signs) for signs in sweep.model.symmetries],
        "equations": program.digest,
        "kernel": digest(print_kernel(program, sweep.method, layout, sweep.dense)),
        **_of_observables(sweep),
        **_of_domain(sweep),
        **{f"engine.{name}": syntax_digest(name) for name in modules},
    }


def _of_observables(sweep: Sweep) -> dict[str, Any]:
    """Return what observables are, where a measure looks at one."""
    names = set(sweep.model.observable_names)
    used = [name for name in sweep.measures.watched if name in names]
    return {"observables": [make_observables(sweep.model).digest, *sweep.model.observable_names]} if used else {}


def _of_domain(sweep: Sweep) -> dict[str, Any]:
    """Return in which interval each state must be, where there is one."""
    states = sweep.model.states
    return {"model.domain": [[s.low.hex(), s.high.hex()] for s in states]} if sweep.model.limited else {}


def _axes(sweep: Sweep) -> dict[str, list[str]]:
    """Return the exact values of what varies."""
    return {
        name if name == axis.name else f"{axis.name}.{name}": [value.hex() for value in values]
        for axis in sweep.grid.axes
        for name, values in axis.quantities.items()
    }


def subject(sweep: Sweep) -> str:
    """Return the identity of what a shard is about: the values and times without which its numbers have no meaning.

    Unlike that of the evidence it is the same for all versions of the engine, so that a reader can tell a config that
    was changed from an engine that was.
    """
    clock = sweep.clock
    times = [clock.dt, clock.block, clock.batch_blocks, clock.segment_batches, clock.transient_segments]
    times += [clock.period_steps] if clock.period_steps else []
    fixed = [sorted(sweep.parameters.items()), sorted(sweep.config.initial.items())]
    rules = [] if sweep.keeps_evidence else [sweep.config.classify.model_dump()]
    return digest([sweep.model.name, list(_axes(sweep).items()), fixed, times, *rules])


@cache
def toolchain() -> dict[str, str]:
    """Return what else decides the bits of a result: compilers, libraries and instructions of the processor."""
    import llvmlite.binding as llvm
    import numpy as np
    import numpy.linalg
    from threadpoolctl import threadpool_info

    loaded = [info for info in threadpool_info() if info["user_api"] == "blas"]
    # Other packages may have brought a BLAS of their own; NumPy's wheel keeps its one beside it.
    blas = [info for info in loaded if any(part.startswith("numpy") for part in Path(info["filepath"]).parts)] or loaded
    features = llvm.get_host_cpu_features()
    return {
        "numba": installed_version("numba"),
        "llvmlite": installed_version("llvmlite"),
        "numpy": installed_version("numpy"),
        "numba settings": " ".join(f"{k}={v}" for k, v in sorted(os.environ.items()) if k in _NUMBA_SETTINGS),
        "fma": str(bool(features.get("fma"))),
        "simd": " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])),
        "blas": " ".join(sorted({f"{b['internal_api']} {b['version']} {b.get('architecture', '')}" for b in blas})),
    }


@dataclass(frozen=True)
class Identity:
    """What decides the numbers of a sweep.

    Parameters
    ----------
    evidence : str
        Of everything that changes an integrated number; without evidence, of the thresholds and their code too.
    toolchain : str
        Of everything else that changes its bits.
    end : str
        Last step, and how much further cells of which regions may go.
    rules : str
        Of the thresholds, of the code that uses them, and of what the model says of its quantities.
    subject : str
        Of the values and times that the numbers are about.
    """

    evidence: str
    toolchain: str
    end: str
    rules: str
    subject: str = ""

    @property
    def result(self) -> str:
        """Identity of the result: of evidence, toolchain, end and rules."""
        return digest([self.evidence, self.toolchain, self.end, self.rules])

    def owner(self, stage: str) -> str:
        """Return what a shard of a stage tells of those who made it."""
        return f"{self.evidence} {self.toolchain} {stage}"


def identify(sweep: Sweep) -> Identity:
    """Return the identity of a sweep on this machine."""
    evidence, tools = digest(evidence_parts(sweep)), digest(toolchain())
    effort = sweep.config.effort
    end = f"{sweep.clock.steps}-{sweep.most_steps}{'-'.join(['', *effort.of]) if effort else ''}"
    model = sweep.model
    told = [repr(model.states), repr(model.parameters), model.time_unit, model.source]
    rules = [sweep.config.classify.model_dump(), *(syntax_digest(name) for name in RESULT_MODULES), *told]
    return Identity(evidence, tools, end, digest(rules), subject(sweep))


def differing(old: dict[str, Any], new: dict[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Return both values of each dotted key whose value differs, None for one that is not there, and orders of axes."""
    before, after = flatten(old), flatten(new)
    pairs = {key: (before.get(key), after.get(key)) for key in sorted({*before, *after})}
    found = {key: (one, other) for key, (one, other) in pairs.items() if one != other}
    axes = [list(data["axes"]) for data in (old, new) if isinstance(data.get("axes"), dict)]
    if len(axes) == 2 and axes[0] != axes[1] and set(axes[0]) == set(axes[1]):
        found["axes.order"] = ", ".join(axes[0]), ", ".join(axes[1])
    return found


def changes_evidence(sweep: Sweep, key: str) -> bool:
    """Whether what is in shards depends on a dotted key of a sweep's config."""
    return not (sweep.keeps_evidence and key.startswith((*_NO_EVIDENCE, "horizon")))


def changed_keys(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """Return a sentence for each dotted key whose value differs."""
    return [f"{key}: {shown(there)} there, {shown(here)} here" for key, (there, here) in differing(old, new).items()]


def shown(value: Any) -> str:
    """Return a value of a config in so many letters that a line holds several."""
    text = "nothing" if value is None else str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def machine() -> dict[str, Any]:
    """Return versions and hardware, for the record of a run; never part of a result."""
    packages = ("numpy", "numba", "llvmlite", "h5py", "dask", "matplotlib", "sympy", "pydantic", "ruamel.yaml")
    return {
        "quavsweep": quavsweep.__version__,
        "python": sys.version.split()[0],
        "packages": {name: installed_version(name) for name in packages},
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
