"""Settings of each tool on regular cells: the error that a step or a tolerance causes, and what it costs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.cells import Cells, make_cells
from benchmarks.peers import heyoka, jitcode
from benchmarks.printed import Printed
from benchmarks.protocol import Contender, Protocol, compare
from benchmarks.reference import reference_state
from quavsweep.kernels.method import METHODS, ButcherTable
from quavsweep.models import load_model

CELLS = 64
SECONDS = 100
SCAN = Protocol(samples=3, seconds=0.1)  # for choosing among settings; the choice is then measured in full
STEPS = tuple(round(100 * 1.08**k) for k in range(97))  # in `SECONDS`: steps of 1 s down to 0.6 ms
TOLERANCES = tuple(float(f"{m}e-{n}") for n in range(4, 16) for m in (3, 1))
JITCODE_TOLERANCES = (1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)


@dataclass(frozen=True)
class Setting:
    """A tool at one step or tolerance.

    Parameters
    ----------
    tool : str
        Name of a peer or of one of our methods.
    label : str
        Its step or tolerance.
    error : float
        Error of the state after `SECONDS`, see `state_error` [rad/s].
    contender : Contender
        Timed per simulated second and cell, with three exponents, orthonormalised every second.
    """

    tool: str
    label: str
    error: float
    contender: Contender


@cache
def regular_cells() -> tuple[Cells, np.ndarray]:
    """Return cells on periodic orbits of the yaw system (c = 5 rad/s), and their states after `SECONDS`.

    They start from where 1,000 s have brought them, so that an error grows with the phase, not exponentially.
    """
    model, varied = load_model("quadrotor_yaw"), {"Omega1": np.linspace(250.0, 280.0, CELLS)}
    settle = Printed(make_cells(model, varied, np.full((CELLS, 3), 1e-3)), 0, 0.02, 50, 1000)
    settle()
    cells = make_cells(model, varied, settle.state())
    return cells, reference_state(cells, SECONDS)


def state_error(state: np.ndarray, reference: np.ndarray) -> float:
    """Return the root mean square over cells of the largest error of a component; infinite for a lost orbit."""
    with np.errstate(invalid="ignore", over="ignore"):
        error = np.sqrt(np.mean(np.abs(state - reference).max(axis=1) ** 2))
    return float(error) if np.isfinite(error) else np.inf


def our_settings(method: ButcherTable) -> Iterator[Setting]:
    """Yield our kernel with longer, then shorter steps, orthonormalising at least every second."""
    cells, reference = regular_cells()
    for steps in STEPS:
        block = steps // SECONDS
        n_blocks = -(-steps // block)
        dt = SECONDS / (block * n_blocks)
        run = Printed(cells, 3, dt, block, n_blocks, method)
        run()
        error = state_error(run.state(), reference)
        if error < 1.0:
            yield Setting(method.name, f"dt = {dt:.3g} s", error, run.per_second(method.name))


def heyoka_settings() -> Iterator[Setting]:
    """Yield heyoka with its cheapest size of a batch and tolerances from loose to tight."""
    sizes = heyoka.batch_sizes()
    cells, reference = regular_cells()
    trials = {size: heyoka.Heyoka(cells, 1e-9, size) for size in sizes}
    size = min(trials, key=lambda n: cost(trials[n].at(SECONDS).per_second()))
    for tolerance in TOLERANCES:
        run = heyoka.Heyoka(cells, tolerance, size)
        error = state_error(run.run(SECONDS)[0], reference)
        label = f"tolerance {tolerance:.0e}, {size} at once"
        yield Setting("heyoka", label, error, run.at(SECONDS).per_second())


def jitcode_settings() -> Iterator[Setting]:
    """Yield JiTCODE with tolerances from loose to tight."""
    jitcode.packages()
    cells, reference = regular_cells()
    for tolerance in JITCODE_TOLERANCES:
        run = jitcode.JitCode(cells, tolerance)
        error = state_error(run.run(SECONDS)[0], reference)
        yield Setting("JiTCODE", f"dop853, tolerance {tolerance:.0e}", error, run.at(SECONDS).per_second())


@cache
def all_settings(tool: str) -> tuple[Setting, ...]:
    """Return the settings of a tool: a method of ours, `heyoka` or `JiTCODE`."""
    peers: dict[str, Callable[[], Iterator[Setting]]] = {"heyoka": heyoka_settings, "JiTCODE": jitcode_settings}
    return tuple(peers[tool]() if tool in peers else our_settings(METHODS[tool]))


def cost(contender: Contender) -> float:
    """Return the time per simulated second and cell [ns], from short samples."""
    return float(np.median(compare([contender], SCAN)[contender.name]))


def cheapest(tools: tuple[str, ...], error: float) -> Setting:
    """Return the cheapest setting of these tools that keeps the error; of each tool, the loosest is tried."""
    candidates = [next((s for s in all_settings(tool) if s.error <= error), None) for tool in tools]
    found = [setting for setting in candidates if setting is not None]
    if not found:
        raise ValueError(f"no setting of {', '.join(tools)} has an error of at most {error:.0e}")
    return min(found, key=lambda setting: cost(setting.contender)) if len(found) > 1 else found[0]


def our_cheapest(error: float) -> Setting:
    """Return our cheapest method and step for an error."""
    return cheapest(tuple(METHODS), error)
