"""The tile loop: advance a segment, look at the cells, drop those that ended, repack, repeat. Tile in, evidence out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from quavsweep.analysis.domain import DomainWatcher
from quavsweep.analysis.observer import make_watchers
from quavsweep.analysis.scene import Chunk, Scene, Watcher
from quavsweep.codes import Certificate, Status
from quavsweep.errors import STOPPED, StoppedError
from quavsweep.grid import Tile
from quavsweep.kernels.layout import Layout, aligned_empty, generic_frame
from quavsweep.look import look
from quavsweep.measures import Evidence
from quavsweep.plan import Plan, cell_values

LOG_STEPS = 400  # a step of RK4 shrinks a vector to no less than 0.27, and 0.27**400 does not underflow
BUFFER_BYTES = 2**21  # of states that dense measures look at together; about the second-level cache
LONGEST_CALL = 0.3  # s, so that a stop is answered soon


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
    n, layout = len(tile), plan.layout
    evidence = {v.name: v.empty(n, plan.sweep.extents) for v in plan.variables}
    evidence["cell"][:] = np.arange(tile.start, tile.stop)
    evidence["status"][:] = Status.TIME_OVER
    evidence["state"][:] = cell_values(plan.sweep, tile)[1]
    if layout.vectors:
        evidence["frame"][:] = generic_frame(layout.dimension, layout.vectors)
    return _integrate(plan, evidence, stopped)


def continue_cells(plan: Plan, begun: Evidence, stopped: Callable[[], bool]) -> Evidence:
    """Take cells on from where other evidence left them; the result is that of one run to the later end.

    Parameters
    ----------
    plan : Plan
        To the later end.
    begun : dict of arrays
        Evidence of some cells of the sweep, integrated to an earlier end.
    stopped : callable
        See `integrate_tile`.

    Raises
    ------
    StoppedError
        If `stopped()` became true.
    """
    n = len(begun["cell"])
    evidence = {v.name: v.empty(n, plan.sweep.extents) for v in plan.variables}
    for name, values in begun.items():
        inside = tuple(slice(0, length) for length in values.shape)
        evidence[name][inside] = values
    _revive(plan, evidence)
    return _integrate(plan, evidence, stopped)


def _revive(plan: Plan, evidence: Evidence) -> None:
    """Let cells go on that ended at the end of a shorter run only because its measures looked no further."""
    end = evidence["steps"].max(initial=0)
    if end < plan.sweep.measures.hold(plan.clock):
        certified = np.isin(evidence["status"], (Status.ENDED_SINK, Status.ENDED_CYCLE))
        evidence["status"][certified & (evidence["steps"] == end)] = Status.TIME_OVER


def _integrate(plan: Plan, evidence: Evidence, stopped: Callable[[], bool]) -> Evidence:
    """Integrate the cells of evidence whose time was over on to the end of the plan."""
    clock, layout = plan.clock, plan.layout
    parameters, _ = cell_values(plan.sweep, evidence["cell"])
    coefficients = plan.program.coefficient_values(parameters)
    scaled = plan.program.coefficient_values(parameters, plan.method.time_unit(clock.dt))
    model = plan.sweep.model
    scene = Scene(
        model, plan.program, plan.method, clock, coefficients, _rows(parameters, len(evidence["cell"])), evidence
    )
    domain = DomainWatcher(scene) if model.limited else None
    watchers = [*([domain] if domain else []), *make_watchers(plan.sweep.measures, scene)]
    alive, begun = _living(plan, evidence)
    totals, volume = _totals(plan, evidence, alive, begun)
    lanes = _pack(plan, evidence, alive, scaled)
    for segment in range(begun, clock.segments):
        if not alive.size:
            break
        batches = []
        for number in range(clock.segment_batches):
            done = (segment * clock.segment_batches + number) * clock.batch_steps
            growth, swelling = _advance_batch(plan, lanes, alive, done, watchers, stopped)
            batches.append(growth)
            totals, volume = totals + growth, volume + swelling
        with np.errstate(all="ignore"):
            for watcher in watchers:
                watcher.settle()
        u = model.wrap(layout.state(lanes, alive.size))
        _record(plan, evidence, alive, u, batches, totals, segment)
        _record_divergence(plan, evidence, alive, coefficients, volume, segment)
        before = evidence["status"][alive]
        ended = domain.left(alive) if domain else np.zeros(alive.size, dtype=bool)
        if domain and ended.any():
            _leave(plan, evidence, alive[ended], domain, watchers, segment)
        if (stay := np.flatnonzero(~ended)).size:
            grown, own = np.sum(batches, axis=0)[stay], [values[alive[stay]] for values in parameters]
            ended[stay] = look(plan, evidence, alive[stay], own, grown)
        broken = alive[(evidence["status"][alive] == Status.DIVERGED) & (before != Status.DIVERGED)]
        for watcher in watchers:
            watcher.void(broken, np.full(broken.size, segment * clock.segment_steps))
        last = segment == clock.segments - 1
        leaving = np.ones_like(ended) if last else ended
        if layout.vectors and leaving.any():
            evidence["frame"][alive[leaving]] = layout.frame(lanes, alive.size)[leaving]
        if ended.any() or model.circles:
            alive, totals, volume = alive[~ended], totals[~ended], volume[~ended]
            if not last:
                lanes = _pack(plan, evidence, alive, scaled, layout.frame(lanes, ended.size)[~ended])
    if plan.sweep.measures.verdict is not None:
        _integrate_beyond(plan, evidence, scaled, stopped)
    return {name: _canonical(values) for name, values in evidence.items()}


def _living(plan: Plan, evidence: Evidence) -> tuple[np.ndarray, int]:
    """Return the cells that go on, and how many segments they have done."""
    steps = int(evidence["steps"].max(initial=0))
    goes_on = evidence["status"] == Status.TIME_OVER
    if steps < plan.sweep.measures.hold(plan.clock):
        goes_on |= evidence["status"] == Status.FRAME_DEGENERATE  # a measure still looks at its state
    return np.flatnonzero(goes_on & (evidence["steps"] == steps)), steps // plan.clock.segment_steps


def _totals(plan: Plan, evidence: Evidence, alive: np.ndarray, begun: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the growth so far of ln of the vectors, (m, exponents), and of the volume, (m,)."""
    if not begun or not plan.layout.exponents:
        return np.zeros((alive.size, plan.layout.exponents)), np.zeros(alive.size)
    return evidence["growth_total"][alive, begun - 1], evidence["divergence"][alive, begun - 1]


def _pack(
    plan: Plan, evidence: Evidence, alive: np.ndarray, scaled: np.ndarray, frame: np.ndarray | None = None
) -> np.ndarray:
    """Return the lanes of the living cells."""
    layout = plan.layout
    if not alive.size:
        return np.zeros((0, layout.rows, layout.lanes))
    if frame is None:
        frame = evidence["frame"][alive] if layout.vectors else np.zeros((alive.size, 0, layout.dimension))
    return layout.pack(evidence["state"][alive], frame, scaled[:, alive])


def _integrate_beyond(plan: Plan, evidence: Evidence, scaled: np.ndarray, stopped: Callable[[], bool]) -> None:
    """Follow one tangent vector beyond the end, in cells of which no certificate tells how they end."""
    clock, (layout, advance) = plan.clock, plan.late
    open_ = np.isin(evidence["certificate"], (Certificate.SINK, Certificate.CYCLE))
    cells = np.flatnonzero((evidence["status"] == Status.TIME_OVER) & ~open_)
    evidence["late_growth"][:] = np.nan
    if not cells.size:
        return
    frame = np.broadcast_to(generic_frame(layout.dimension, 1), (cells.size, 1, layout.dimension))
    lanes = layout.pack(evidence["state"][cells], frame, scaled[:, cells])
    for batch in range(evidence["late_growth"].shape[1]):
        growth, _ = _advance_batch(
            plan, lanes, cells, clock.steps + batch * clock.batch_steps, (), stopped, (layout, advance)
        )
        evidence["late_growth"][cells, batch] = growth[:, 0]


def _advance_batch(
    plan: Plan,
    lanes: np.ndarray,
    alive: np.ndarray,
    done: int,
    watchers: Sequence[Watcher],
    stopped: Callable[[], bool],
    kernel: tuple[Layout, Callable[..., None]] | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Advance all lanes, which have done so many steps, by a batch.

    Returns
    -------
    growth : (n, exponents) float64
        Of ln of the tangent vectors.
    volume : (n,) float64
        Integral of the divergence, 0 where the kernel does not follow it.
    """
    clock, (layout, advance) = plan.clock, kernel or (plan.layout, plan.advance)
    flat, groups = lanes.reshape(-1), lanes.shape[0]
    growth, volume = np.zeros((groups, layout.exponents, layout.lanes)), np.zeros((groups, 1, layout.lanes))
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
                raise StoppedError(STOPPED)
            last = min(first + at_once, groups)
            if watchers:
                cells = alive[first * layout.lanes : last * layout.lanes]
                _watch(plan, flat, (first, last), blocks, cells, done + block * clock.block, watchers)
            else:
                advance(flat, first, last, blocks, clock.block)
        with np.errstate(all="ignore"):
            layout.add_growth(lanes, growth, volume)
    return layout.cells(growth, alive.size), layout.cells(volume, alive.size)[:, 0]


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
    chunk = Chunk(cells, done, u)
    with np.errstate(all="ignore"):
        for watcher in watchers:
            watcher.see(chunk)


def _rows(parameters: Sequence[np.ndarray], n: int) -> np.ndarray:
    """Return the parameters of n cells, (P, n)."""
    return np.array(parameters).reshape(-1, n)


def _leave(
    plan: Plan, evidence: Evidence, cells: np.ndarray, domain: DomainWatcher, watchers: Sequence[Watcher], segment: int
) -> None:
    """Write how cells ended that left the domain in a segment; what was recorded of it means nothing."""
    known = domain.write(cells)
    if plan.layout.exponents:
        evidence["growth"][cells, segment * plan.clock.segment_batches :] = np.nan
        evidence["growth_total"][cells, segment:] = np.nan
    for watcher in watchers:
        watcher.void(cells, known)


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


def _record_divergence(
    plan: Plan, evidence: Evidence, alive: np.ndarray, coefficients: np.ndarray, volume: np.ndarray, segment: int
) -> None:
    """Write the integral of the divergence from t = 0: what the kernel followed, or exact where it is constant."""
    if not plan.layout.exponents:
        return
    if plan.layout.trace:
        evidence["divergence"][alive, segment] = volume
    elif (constant := plan.program.constant_divergence(coefficients[:, alive])) is not None:
        time = (segment + 1) * plan.clock.segment_steps * plan.clock.dt
        evidence["divergence"][alive, segment] = constant * time


def _canonical(values: np.ndarray) -> np.ndarray:
    """Return values whose NaN and zero have one bit pattern, since the processor's choice may vary."""
    if values.dtype.kind != "f":
        return values
    return np.where(np.isnan(values), np.array(np.nan, values.dtype), values + values.dtype.type(0))
