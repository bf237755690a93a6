"""The printed kernel against the same arithmetic in C, measured side by side: `python -m benchmarks.kernel`.

Both advance the same cells of the yaw system by RK4 with three tangent vectors and no orthonormalisation. Samples
alternate, each at least `SAMPLE_SECONDS` long; compilation is left out on both sides.
"""

from __future__ import annotations

import ctypes
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from quavsweep.integrate import generic_frame
from quavsweep.kernels.compiler import default_lanes, make_advance
from quavsweep.kernels.layout import Layout, aligned_empty
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.method import RK4
from quavsweep.models import load_model

SOURCE = Path(__file__).with_name("step_yaw.c")
FLAGS = ("-O3", "-march=native", "-ffast-math", "-shared", "-fPIC")
C_LANES = 8
CELLS = 256  # as many as fit the first-level cache with room to spare
DT = 0.02
STEPS = 1000  # in a row, from the same start each time, so that no tangent vector overflows
SAMPLES = 7
SAMPLE_SECONDS = 2.0


@dataclass(frozen=True)
class Contender:
    """One way to advance the cells: its lanes, their start, and the call that advances them by `STEPS`."""

    lanes: np.ndarray
    fresh: np.ndarray
    advance: Callable[[], object]

    def run(self, times: int) -> float:
        """Advance the cells so many times from their start and return the seconds it took."""
        began = time.perf_counter()
        for _ in range(times):
            self.lanes[...] = self.fresh
            self.advance()
        return time.perf_counter() - began

    def state(self) -> np.ndarray:
        """Return the cells' states, (n, 3)."""
        return self.lanes[:, :3].transpose(0, 2, 1).reshape(-1, 3)


def main() -> int:
    """Print both times per step and cell and their ratio; return 1 if there is no gcc."""
    compiler = shutil.which("gcc")
    if compiler is None:
        print("gcc is missing: the kernel cannot be compared with C")
        return 1
    with tempfile.TemporaryDirectory() as folder:
        contenders = {"printed kernel": printed(), "C, vector types": handwritten(compiler, Path(folder))}
        samples = compare(contenders)
    for name, values in samples.items():
        print(
            f"{name:16} {statistics.median(values):6.2f} ns per step and cell, {min(values):.2f} to {max(values):.2f}"
        )
    ratios = [a / b for a, b in zip(*samples.values(), strict=True)]
    print(f"{'ratio':16} {statistics.median(ratios):6.2f}, {min(ratios):.2f} to {max(ratios):.2f}")
    return 0


def start() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return states (n, 3), frames (n, 3, 3) and coefficients (9, n) of the cells that are advanced."""
    model = load_model("quadrotor_yaw")
    parameters = {name: np.full(CELLS, value) for name, value in model.defaults.items()}
    parameters["Omega1"] = np.linspace(50.0, 500.0, CELLS)
    u = np.random.default_rng(0).uniform(-1.0, 1.0, (CELLS, 3))
    frame = np.broadcast_to(generic_frame(3, 3), (CELLS, 3, 3))
    return u, frame, make_program(model).coefficient_values(list(parameters.values()))


def printed() -> Contender:
    """Return the printed kernel; it orthonormalises once in `STEPS`."""
    u, frame, coefficients = start()
    layout = Layout(3, 3, len(coefficients), default_lanes())
    advance = make_advance(make_program(load_model("quadrotor_yaw")), RK4, layout)
    lanes = layout.pack(u, frame, coefficients)
    flat, groups = lanes.reshape(-1), lanes.shape[0]
    return Contender(lanes, lanes.copy(), lambda: advance(flat, 0, groups, 1, STEPS, DT))


def handwritten(compiler: str, folder: Path) -> Contender:
    """Compile the C source and return its step."""
    library = folder / "step_yaw.so"
    subprocess.run([compiler, *FLAGS, str(SOURCE), "-o", str(library)], check=True)
    advance = ctypes.CDLL(str(library)).advance
    advance.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t, ctypes.c_double)
    u, frame, coefficients = start()
    table = np.concatenate([u.T, frame.reshape(CELLS, -1).T, coefficients])
    fresh = table.reshape(len(table), -1, C_LANES).transpose(1, 0, 2)
    lanes = aligned_empty(fresh.shape)
    return Contender(lanes, fresh, lambda: advance(lanes.ctypes.data, lanes.shape[0], STEPS, DT))


def compare(contenders: dict[str, Contender], sample_seconds: float = SAMPLE_SECONDS) -> dict[str, list[float]]:
    """Return the times per step and cell [ns] of interleaved samples.

    Raises
    ------
    ValueError
        If the contenders do not compute the same.
    """
    first, second = contenders.values()
    times = max(1, round(sample_seconds / max(first.run(1), first.run(1))))
    second.run(1)
    if not np.allclose(first.state(), second.state(), rtol=1e-9, atol=1e-9):
        raise ValueError("the contenders do not compute the same")
    samples: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(SAMPLES):
        for name, contender in contenders.items():
            samples[name].append(contender.run(times) / times / STEPS / CELLS * 1e9)
    return samples


if __name__ == "__main__":
    sys.exit(main())
