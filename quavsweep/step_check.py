"""The error that the step causes: some regular cells of a tile, integrated again with half the step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from quavsweep.clock import Clock
from quavsweep.codes import Certificate
from quavsweep.config import Sweep
from quavsweep.grid import Tile
from quavsweep.integrate import BUFFER_BYTES, LONGEST_CALL
from quavsweep.kernels.layout import aligned_empty, generic_frame
from quavsweep.measures import Evidence
from quavsweep.plan import Plan, cell_values

TIME = 100.0  # in the model's time
CALM = 3.0  # growth of ln of the distance of nearby orbits that leaves an error what it is, but for a factor of 20
SHARE = 0.005  # of the run's work that the check may cost; in shorter runs it covers less time


@dataclass(frozen=True)
class StepError:
    """How far the states of regular cells are off, because the step is finite.

    Parameters
    ----------
    dt, time : float
        The step, and the time from the initial state after which states were compared [time unit of the model].
    median, largest : float
        Over the cells: the largest error of a state there, as a share of that state's largest magnitude.
    cells : int
        Number of cells compared.
    """

    dt: float
    time: float
    median: float
    largest: float
    cells: int


def regular_cells(sweep: Sweep, evidence: Evidence, classified: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return which cells are certified and show the error of the step alone, (n,) bool: in chaos any error explodes.

    Those are cells whose nearby orbits never part by more than a factor of 20 within the time compared, because chaos
    may also end before the first look; where no exponents are measured, the quarter that settled first.
    """
    certified = np.isin(evidence["certificate"], (Certificate.SINK, Certificate.CYCLE))
    if sweep.measures.lyapunov is None:
        settled = classified["settle_time"]
        first = np.quantile(settled[certified], 0.25) if certified.any() else 0.0
        return np.asarray(certified & (settled <= first))
    clock = sweep.clock
    batches = max(1, math.ceil(TIME / (clock.batch_steps * clock.dt) - 1e-9))
    growth = np.nan_to_num(evidence["growth"][:, :batches, 0].astype(np.float64))  # NaN behind a cell's end
    path = np.concatenate([np.zeros((len(growth), 1)), growth.cumsum(axis=1)], axis=1)
    rise = (path - np.minimum.accumulate(path, axis=1)).max(axis=1)
    return np.asarray(certified & (classified["was_chaotic"] == 0) & (rise <= CALM))


def check_step(
    plan: Plan, tile: Tile, regular: np.ndarray, steps_of_run: float, stopped: Callable[[], bool]
) -> StepError | None:
    """Return the error of the state that the step causes, estimated as by Richardson from a run with half the step.

    Parameters
    ----------
    plan : Plan
    tile : Tile
    regular : (n,) bool
        The cells that may be taken, up to one group of lanes of them.
    steps_of_run : float
        Steps of all cells of the run, as far as that is known.
    stopped : callable
        Asked now and then.

    Returns
    -------
    StepError or None
        None if no cell is regular, or if `stopped()` became true.
    """
    clock, lanes = plan.clock, plan.layout.lanes
    cells = np.flatnonzero(regular)
    if not cells.size:
        return None
    cells = cells[np.linspace(0, cells.size - 1, min(lanes, cells.size)).round().astype(int)]
    parameters, u = cell_values(plan.sweep, tile)
    parameters, start = [values[cells] for values in parameters], u[cells]
    steps = min(TIME / clock.dt, clock.steps, SHARE * steps_of_run / (3 * lanes))
    blocks = max(1, math.ceil(steps / clock.block - 1e-9))
    finer = replace(clock, dt=clock.dt / 2, period_steps=2 * clock.period_steps)
    whole = _advanced(plan, start, parameters, clock, blocks, stopped)
    half = _advanced(plan, start, parameters, finer, 2 * blocks, stopped)
    if whole is None or half is None:
        return None
    order = 2.0**plan.method.order
    with np.errstate(all="ignore"):
        size = np.maximum(np.abs(start), np.abs(half)).max(axis=0)
        error = np.abs(whole - half) * (order / (order - 1)) / np.where(size > 0, size, 1.0)
    worst = np.nan_to_num(error, nan=np.inf).max(axis=1)
    time = blocks * clock.block * clock.dt
    return StepError(clock.dt, time, float(np.median(worst)), float(worst.max()), int(cells.size))


def _advanced(
    plan: Plan, u: np.ndarray, parameters: list[np.ndarray], clock: Clock, blocks: int, stopped: Callable[[], bool]
) -> np.ndarray | None:
    """Return the states after so many blocks of steps of a clock, with the kernel of the plan."""
    layout, block, n = plan.layout, clock.block, len(u)
    frame = np.broadcast_to(generic_frame(layout.dimension, layout.vectors), (n, layout.vectors, layout.dimension))
    lanes = layout.pack(u, frame, plan.program.coefficient_values(parameters, plan.method.time_unit(clock.dt)))
    groups = lanes.shape[0]
    dense = plan.sweep.dense
    state_bytes = 8 * groups * layout.dimension * layout.lanes
    steps = BUFFER_BYTES / state_bytes if dense else 1e9 * LONGEST_CALL / (groups * layout.lanes * plan.step_ns)
    most = max(1, int(steps / block))
    for done in range(0, blocks, most):
        if stopped():
            return None
        now = min(most, blocks - done)
        layout.set_phase(lanes, clock.phase(done * block))
        buffer = [aligned_empty((groups * (now * block + 1) * layout.dimension * layout.lanes,))] if dense else []
        plan.advance(lanes.reshape(-1), 0, groups, now, block, *buffer)
    return layout.state(lanes, n)
