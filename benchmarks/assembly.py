"""Reading machine code: the arithmetic of the innermost loop with the most of it."""

from __future__ import annotations

import importlib.util
import re
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path
from types import ModuleType

from quavsweep.kernels.compiler import assembly

Instruction = tuple[str, str]  # name and operands

ARITHMETIC = re.compile(r"^v?(?:add|sub|mul|div|sqrt|max|min|fn?m(?:add|sub)\d*)([ps]d)$")


def hottest_loop(text: str) -> list[Instruction]:
    """Return the instructions of the innermost loop with the most arithmetic, from assembly in AT&T syntax."""
    lines = [line.strip() for line in text.splitlines()]
    labels = {line[:-1]: i for i, line in enumerate(lines) if line.endswith(":")}
    loops = []
    for i, line in enumerate(lines):
        jump = re.match(r"j\w+\s+(\S+)$", line)
        if jump and labels.get(jump[1], i) < i:
            loops.append(lines[labels[jump[1]] : i])
    inner = [loop for loop in loops if not any(loop is not x and x[0] in loop[1:] for x in loops)]
    bodies = [[(m[1], m[2]) for m in (re.match(r"(v?[a-z]\w*)\s+(.*)$", x) for x in loop) if m] for loop in inner]
    return max(bodies, key=lambda body: sum(bool(ARITHMETIC.match(name)) for name, _ in body))


def kinds(body: list[Instruction]) -> Counter[str]:
    """Return how many arithmetic instructions are packed (pd) and how many scalar (sd)."""
    return Counter(match[1] for match in (ARITHMETIC.match(name) for name, _ in body) if match)


def compile_afresh(source: str, folder: Path) -> ModuleType:
    """Import a printed kernel from a new folder, because numba keeps no assembly of what it loads from its cache."""
    path = folder / "kernel.py"
    path.write_text(source)
    spec = importlib.util.spec_from_file_location("kernel_afresh", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def printed_loop(source: str) -> list[Instruction]:
    """Return the hottest loop of a printed kernel."""
    with tempfile.TemporaryDirectory() as folder:
        return hottest_loop(assembly(compile_afresh(source, Path(folder)).advance))
