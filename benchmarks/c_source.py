"""The C sources beside this file: compiled at run time with gcc for the machine at hand."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from benchmarks.assembly import Instruction, hottest_loop
from benchmarks.protocol import MissingError

FLAGS = ("-O3", "-march=native", "-ffast-math", "-fPIC")


def gcc() -> str:
    """Return the path of gcc.

    Raises
    ------
    MissingError
        If there is none.
    """
    path = shutil.which("gcc")
    if path is None:
        raise MissingError("gcc is missing")
    return path


@cache
def vector_bytes() -> int:
    """Return the width of the processor's vectors: 64 bytes with AVX-512F, else 32."""
    flags = subprocess.run(
        [gcc(), "-march=native", "-dM", "-E", "-x", "c", "/dev/null"], check=True, capture_output=True, text=True
    )
    return 64 if "__AVX512F__" in flags.stdout else 32


def library(name: str, **defines: int) -> ctypes.CDLL:
    """Compile a source as a shared library and load it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "benchmark.so"
        _compile(name, path, "-shared", defines)
        return ctypes.CDLL(str(path))


def loop(name: str, **defines: int) -> list[Instruction]:
    """Compile a source to assembly and return its hottest loop."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "benchmark.s"
        _compile(name, path, "-S", defines)
        return hottest_loop(path.read_text())


def _compile(name: str, target: Path, kind: str, defines: dict[str, int]) -> None:
    source = Path(__file__).with_name(name)
    options = [f"-D{key}={value}" for key, value in {"BYTES": vector_bytes(), **defines}.items()]
    subprocess.run([gcc(), *FLAGS, *options, kind, str(source), "-o", str(target)], check=True)
