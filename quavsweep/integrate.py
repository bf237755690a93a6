"""The tile loop: advance a segment, look at the cells, drop those that ended, repack, repeat. Tile in, evidence out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from quavsweep.analysis.certificate import examine
from quavsweep.analysis.observer import Chunk, Scene, Watcher, make_watchers
from quavsweep.clock import Clock
from quavsweep.codes import Certificate, Status
from quavsweep.config import Sweep
from quavsweep.errors import StoppedError
from quavsweep.grid import Tile
from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.layout import Layout, aligned_empty
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.printer import step_operations
from quavsweep.kernels.program import Program
from quavsweep.kernels.step import choose_layout
from quavsweep.measures import Evidence, Variable

LOG_STEPS = 400  # a step of RK4 shrinks a vector to no less than 0.27, and 0.27**400 does not underflow
FULL_RANK = 27.6  # ln 1e12: vectors that a block stretches more unequally are parallel to rounding when it ends
BUFFER_BYTES = 2**21  # of states that dense measures look at together; about the second-level cache
LONGEST_CALL = 0.3  # s, so that a stop is answered soon
OPERATION_NS = 0.033  # time of one operation of the step in one lane, from the cost of the printed kernels


@dataclass(frozen=True)
class Plan:
    """All that integrating a tile needs, ready to run.

    Parameters
    ----------
    sweep : Sweep
    program : Program
    layout : Layout
    advance : callable
        The compiled kernel; `record` where a measure is dense.
    """

    sweep: Sweep
    program: Program
    layout: Layout
    advance: Callable[..., None]

    @property
    def clock(self) -> Clock:
        """Lengths of time in steps."""
        return self.sweep.clock

    @property
    def method(self) -> ButcherTable:
        """The Runge-Kutta table."""
        return self.sweep.method

    @property
    def variables(self) -> tuple[Variable, ...]:
        """What the evidence holds."""
        return self.sweep.measures.evidence

    @cached_property
    def step_ns(self) -> float:
        """Estimated time of one step of one cell [ns], the same on every machine."""
        return OPERATION_NS * step_operations(self.program, self.method, self.layout)


def make_plan(sweep: Sweep, lanes: int) -> Plan:
    """Return the plan of a sweep with a compiled kernel of so many lanes."""
    program = make_program(sweep.model)
    layout = choose_layout(program, sweep.method, sweep.measures.vectors, lanes, sweep.measures.trace)
    return Plan(sweep, program, layout, make_advance(program, sweep.method, layout, sweep.measures.dense))


def generic_frame(dimension: int, vectors: int) -> np.ndarray:
    """Return orthonormal vectors that are aligned with no coordinate plane, (K, D).

    A frame along the axes would never leave an invariant subspace and miss exponents; this one is the reflection
    I - 2 v v^T / v^T v with v_i the square roots of 1/2, 3/2, 5/2 ..., none of whose entries vanishes.
    """
    v = np.sqrt(np.arange(dimension) + 0.5)
    return np.asarray((np.eye(dimension) - 2.0 * np.outer(v, v) / (v @ v))[:vectors])


def cell_values(sweep: Sweep, tile: Tile) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the parameters of a tile's cells, (n,) each in the model's order, and their initial states, (n, D)."""
    n = len(tile)
    varied = sweep.grid.coordinates(tile.start, tile.stop)
    fixed = {**sweep.parameters, **sweep.config.initial}
    value = {name: varied.get(name, np.full(n, fixed.get(name))) for name in (*fixed, *varied)}
    parameters = [np.asarray(value[name], dtype=np.float64) for name in sweep.model.parameter_names]
    return parameters, np.stack([value[name] for name in sweep.model.state_names], axis=1).astype(np.float64)


def integrate_tile(plan: Plan, tile: Tile, stopped: Callable[[], bool]) -> Evidence:
    """Integrate the cells of a tile and return their evidence.

    Parameters
    ----------
    plan : Plan
    tile : Tile
    stopped : callable
        Asked between calls of the kernel, which take at most 0.3 s each.

    Returns
    -------
    dict of arrays
        One per variable of `plan.variables`, (n, ...) each. A cell's numbers do not depend on its tile.

    Raises
    ------
    StoppedError
        If `stopped()` became true.
    """
    clock, layout, n = plan.clock, plan.layout, len(tile)
    evidence = {v.name: v.empty(n, plan.sweep.extents) for v in plan.variables}
    evidence["cell"][:] = np.arange(tile.start, tile.stop)
    evidence["status"][:] = Status.TIME_OVER
    parameters, u = cell_values(plan.sweep, tile)
    coefficients = plan.program.coefficient_values(parameters)
    scaled = plan.program.coefficient_values(parameters, plan.method.time_unit(clock.dt))
    frame = np.broadcast_to(generic_frame(layout.dimension, layout.vectors), (n, layout.vectors, layout.dimension))
    alive = np.arange(n)
    lanes = layout.pack(u, frame, scaled)
    totals = np.zeros((n, layout.exponents))
    scene = Scene(plan.sweep.model, plan.program, plan.method, clock, coefficients, evidence)
    watchers = make_watchers(plan.sweep.measures, scene)
    for segment in range(clock.segments):
        batches = []
        for number in range(clock.segment_batches):
            done = (segment * clock.segment_batches + number) * clock.batch_steps
            batches.append(_advance_batch(plan, lanes, alive, done, watchers, stopped))
            totals = totals + batches[-1]
        with np.errstate(all="ignore"):
            for watcher in watchers:
                watcher.settle()
        _record(plan, evidence, alive, layout.state(lanes, alive.size), batches, totals, segment)
        last = segment == clock.segments - 1
        before = evidence["status"][alive]
        ended = _look(plan, evidence, alive, coefficients[:, alive], np.sum(batches, axis=0), last)
        for watcher in watchers:
            watcher.void(alive[(evidence["status"][alive] == Status.DIVERGED) & (before != Status.DIVERGED)])
        leaving = np.ones_like(ended) if last else ended
        if layout.vectors and leaving.any():
            evidence["frame"][alive[leaving]] = layout.frame(lanes, alive.size)[leaving]
        if leaving.any():
            frame = layout.frame(lanes, alive.size)[~leaving]
            alive, totals = alive[~leaving], totals[~leaving]
            if not alive.size:
                break
            lanes = layout.pack(evidence["state"][alive], frame, scaled[:, alive])
    return {name: _canonical(values) for name, values in evidence.items()}


def _advance_batch(
    plan: Plan,
    lanes: np.ndarray,
    alive: np.ndarray,
    done: int,
    watchers: Sequence[Watcher],
    stopped: Callable[[], bool],
) -> np.ndarray:
    """Advance all lanes, which have done so many steps, by a batch; return the growth of ln, (n, exponents)."""
    clock, layout = plan.clock, plan.layout
    flat, groups = lanes.reshape(-1), lanes.shape[0]
    growth = np.zeros((groups, layout.exponents, layout.lanes))
    most = max(1, LOG_STEPS // clock.block)
    if watchers:
        at_once = max(1, BUFFER_BYTES // (8 * (most * clock.block + 1) * layout.dimension * layout.lanes))
    else:
        at_once = max(1, int(1e9 * LONGEST_CALL / (most * clock.block * layout.lanes * plan.step_ns)))
    for block in range(0, clock.batch_blocks, most):
        blocks = min(most, clock.batch_blocks - block)
        layout.set_phase(lanes, clock.phase(done + block * clock.block))
        for first in range(0, groups, at_once):
            if stopped():
                raise StoppedError("the run was stopped")
            last = min(first + at_once, groups)
            if watchers:
                cells = alive[first * layout.lanes : last * layout.lanes]
                _watch(plan, flat, (first, last), blocks, cells, done + block * clock.block, watchers)
            else:
                plan.advance(flat, first, last, blocks, clock.block)
        if layout.exponents:
            with np.errstate(all="ignore"):
                layout.add_growth(lanes, growth)
    return layout.cells(growth, alive.size)


def _watch(
    plan: Plan,
    flat: np.ndarray,
    groups: tuple[int, int],
    blocks: int,
    cells: np.ndarray,
    done: int,
    watchers: Sequence[Watcher],
) -> None:
    """Advance some groups of lanes and show the states of their cells after every step to the watchers."""
    clock, layout = plan.clock, plan.layout
    steps, (first, last) = blocks * clock.block, groups
    buffer = aligned_empty((last - first, steps + 1, layout.dimension, layout.lanes))
    plan.advance(flat, first, last, blocks, clock.block, buffer.reshape(-1))
    u = buffer.transpose(1, 2, 0, 3).reshape(steps + 1, layout.dimension, -1)[:, :, : cells.size]
    with np.errstate(all="ignore"):
        for watcher in watchers:
            watcher.see(Chunk(cells, done, u))


def _record(
    plan: Plan,
    evidence: Evidence,
    alive: np.ndarray,
    u: np.ndarray,
    batches: list[np.ndarray],
    totals: np.ndarray,
    segment: int,
) -> None:
    """Write a segment's state and growth into the evidence."""
    clock = plan.clock
    evidence["steps"][alive] = (segment + 1) * clock.segment_steps
    evidence["state"][alive] = u
    if plan.layout.exponents:
        first = segment * clock.segment_batches
        evidence["growth"][alive, first : first + clock.segment_batches] = np.stack(batches, axis=1)
        evidence["growth_total"][alive, segment] = totals


def _look(
    plan: Plan, evidence: Evidence, alive: np.ndarray, coefficients: np.ndarray, grown: np.ndarray, last: bool
) -> np.ndarray:
    """Look at the living cells after a segment; write what is certain and return which of them have ended.

    `grown` is the growth of ln in the segment, (n, exponents).
    """
    clock = plan.clock
    u, steps = evidence["state"][alive], evidence["steps"][alive]
    diverged, degenerate = _breakdowns(plan, evidence, alive, grown)
    # A cell may be certified, or lose its frame, long before the measures let it end.
    looked_at = int(steps[0]) < plan.sweep.measures.hold(clock)
    ended = np.asarray(diverged | (degenerate & (not looked_at)))
    may_end = plan.sweep.config.stop_early and not looked_at
    if may_end:
        certified = ~ended & (evidence["certificate"][alive] == Certificate.SINK)
        evidence["status"][alive[certified]] = Status.ENDED_SINK
        ended |= certified
    open_ = np.flatnonzero(~ended & ~degenerate & (evidence["certificate"][alive] == Certificate.NONE))
    if open_.size:
        ends = examine(plan.program, plan.method, clock.dt, u[open_], coefficients[:, open_])
        _certify(evidence, alive[open_], ends.inside, Certificate.SINK, ends.equilibrium, ends.eigenvalues)
        settled = alive[open_[ends.inside]]
        evidence["certified_steps"][settled] = steps[open_[ends.inside]]
        evidence["settled_steps"][settled] = steps[open_[ends.inside]] - clock.segment_steps
        if may_end:
            evidence["status"][settled] = Status.ENDED_SINK
            ended[open_[ends.inside]] = True
        if last:
            resting = ends.resting & ~ends.inside
            _certify(evidence, alive[open_], resting, Certificate.REST, ends.equilibrium, ends.eigenvalues)
    return ended


def _breakdowns(plan: Plan, evidence: Evidence, alive: np.ndarray, grown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the cells that diverged and those whose frame has lost rank; give them their status, void their growth."""
    clock, u = plan.clock, evidence["state"][alive]
    diverged = ~plan.sweep.model.within_bound(u)  # also where it is no number
    degenerate = np.zeros_like(diverged)
    if plan.layout.exponents:
        # All cells of a tile have been integrated equally far; a comparison with NaN or inf is no full rank.
        segment = int(evidence["steps"][alive[0]]) // clock.segment_steps - 1
        vectors = grown.T[: plan.layout.vectors] / (clock.segment_batches * clock.batch_blocks)
        with np.errstate(invalid="ignore"):
            full_rank = vectors.max(axis=0) - vectors.min(axis=0) <= FULL_RANK if len(vectors) else ~diverged
        degenerate = (~full_rank | (evidence["status"][alive] == Status.FRAME_DEGENERATE)) & ~diverged
        if (void := alive[diverged | degenerate]).size:
            evidence["growth"][void, segment * clock.segment_batches :] = np.nan
            evidence["growth_total"][void, segment:] = np.nan
    evidence["status"][alive[diverged]] = Status.DIVERGED
    evidence["status"][alive[degenerate]] = Status.FRAME_DEGENERATE
    return diverged, degenerate


def _certify(
    evidence: Evidence,
    cells: np.ndarray,
    which: np.ndarray,
    certificate: Certificate,
    equilibrium: np.ndarray,
    eigenvalues: np.ndarray,
) -> None:
    """Write a certificate, its equilibrium and eigenvalues for some cells."""
    evidence["certificate"][cells[which]] = certificate
    evidence["equilibrium"][cells[which]] = equilibrium[which]
    evidence["eigenvalue_re"][cells[which]] = eigenvalues[which].real
    evidence["eigenvalue_im"][cells[which]] = eigenvalues[which].imag


def _canonical(values: np.ndarray) -> np.ndarray:
    """Return values whose NaN and zero have one bit pattern, since the processor's choice may vary."""
    if values.dtype.kind != "f":
        return values
    return np.where(np.isnan(values), np.array(np.nan, values.dtype), values + values.dtype.type(0))
