"""Looks: what is certain of cells after a segment, written into their evidence."""

from __future__ import annotations

import numpy as np

from quavsweep.analysis.certificate import Ends, examine
from quavsweep.codes import Certificate, Status
from quavsweep.measures import Evidence
from quavsweep.plan import Plan

FULL_RANK = 27.6  # ln 1e12: vectors that a block stretches more unequally are parallel to rounding when it ends
CALM = 4.0  # growth of ln along a cycle in a segment is bounded by its fastest against its slowest stretch
EVERY = 4  # looks; each of these follows an orbit for so many segments, so that cycles of half that length are seen
LONGEST_STRETCH = 16  # segments that a look follows an orbit, at most


def look(
    plan: Plan, evidence: Evidence, alive: np.ndarray, parameters: list[np.ndarray], grown: np.ndarray
) -> np.ndarray:
    """Look at the living cells after a segment; write what is certain and return which of them have ended.

    Only a divergence, a lost frame or a certificate ends a cell. A certificate stands once it is found; that a state
    rests on an equilibrium which is not proved to attract it holds as long as it does.

    Parameters
    ----------
    alive : (m,) int
        Rows of the evidence; their states and steps are those at the end of the segment.
    parameters : list of (m,) arrays
        Of the living cells, in the model's order.
    grown : (m, exponents) float64
        Growth of ln in the segment.

    Returns
    -------
    (m,) bool
    """
    clock = plan.clock
    steps = int(evidence["steps"][alive[0]])
    diverged, degenerate = _breakdowns(plan, evidence, alive, grown)
    # A cell may be certified, or lose its frame, long before the measures let it end.
    looked_at = steps < plan.sweep.measures.hold(clock)
    ended = np.asarray(diverged | (degenerate & (not looked_at)))
    certificate = evidence["certificate"]
    open_ = np.flatnonzero(~diverged & ~np.isin(certificate[alive], (Certificate.SINK, Certificate.CYCLE)))
    if open_.size:
        _examine(plan, evidence, alive[open_], [p[open_] for p in parameters])
    open_ = np.flatnonzero(~diverged & (certificate[alive] == Certificate.NONE))
    if grown.shape[1]:
        calm = grown[open_, 0] <= CALM if plan.sweep.model.forcing_period else np.abs(grown[open_, 0]) <= CALM
        open_ = open_[calm | degenerate[open_]]
    if open_.size:
        _find_cycles(plan, evidence, alive[open_], [p[open_] for p in parameters])
    if plan.sweep.config.stop_early and not looked_at:
        ends = {Certificate.SINK: Status.ENDED_SINK, Certificate.CYCLE: Status.ENDED_CYCLE}
        for proof, status in ends.items():
            proved = ~diverged & (certificate[alive] == proof)
            if proof == Certificate.CYCLE:
                proved &= _sampled(plan, evidence, alive)
            evidence["status"][alive[proved]] = status
            ended |= proved
    return ended


def _sampled(plan: Plan, evidence: Evidence, alive: np.ndarray) -> np.ndarray:
    """Return which cells have all samples that they are to have, (m,) bool: of a cycle they are more than a point."""
    samples = plan.sweep.measures.samples
    return np.ones(alive.size, dtype=bool) if samples is None else evidence["sample_count"][alive] >= samples.max


def _breakdowns(plan: Plan, evidence: Evidence, alive: np.ndarray, grown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the cells that diverged and those whose frame has lost rank; give them their status, void their growth."""
    clock, u = plan.clock, evidence["state"][alive]
    diverged = np.asarray(~plan.sweep.model.bounded(u))  # also where it is no number
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


def _examine(plan: Plan, evidence: Evidence, cells: np.ndarray, parameters: list[np.ndarray]) -> None:
    """Write down which cells are bound to end in an equilibrium, and which rest on one."""
    coefficients = plan.program.coefficient_values(parameters)
    ends = examine(plan.program, plan.method, plan.clock.dt, evidence["state"][cells], coefficients)
    _certify(plan, evidence, cells[ends.inside], Certificate.SINK)
    _write_equilibrium(evidence, cells, ends, ends.inside)
    resting = ends.resting & ~ends.inside
    lasting = evidence["certificate"][cells] == Certificate.REST
    evidence["certificate"][cells[resting]] = Certificate.REST
    _write_equilibrium(evidence, cells, ends, resting)
    begins = cells[resting & ~lasting]
    evidence["rest_steps"][begins] = evidence["steps"][begins]
    over = lasting & ~resting
    evidence["rest_steps"][cells[over]] = 0
    left = cells[over & ~ends.inside]
    evidence["certificate"][left] = Certificate.NONE
    for name in ("equilibrium", "eigenvalue_re", "eigenvalue_im"):
        evidence[name][left] = np.nan


def _write_equilibrium(evidence: Evidence, cells: np.ndarray, ends: Ends, which: np.ndarray) -> None:
    evidence["equilibrium"][cells[which]] = ends.equilibrium[which]
    evidence["eigenvalue_re"][cells[which]] = ends.eigenvalues[which].real
    evidence["eigenvalue_im"][cells[which]] = ends.eigenvalues[which].imag


def _find_cycles(plan: Plan, evidence: Evidence, cells: np.ndarray, parameters: list[np.ndarray]) -> None:
    """Write down which cells are bound to end in a cycle.

    A look follows an orbit for a segment, every fourth one for four; only where the number of segments done is a power
    of two it may take more, so that long periods are found too without doubling the work on orbits that never return.
    """
    clock = plan.clock
    done = int(evidence["steps"][cells[0]]) // clock.segment_steps
    segments = EVERY if done % EVERY == 0 else 1
    if done & (done - 1) == 0:
        segments = min(done, LONGEST_STRETCH)
    cycles = plan.search.find(evidence["state"][cells], parameters, clock.segment_steps * segments)
    first = cells[cycles.close & (evidence["close_steps"][cells] == 0)]
    evidence["close_steps"][first] = evidence["steps"][first]
    rests, closed = cycles.found & cycles.resting, cycles.found & ~cycles.resting
    _certify(plan, evidence, cells[rests], Certificate.SINK)
    evidence["equilibrium"][cells[rests]] = cycles.point[rests]
    evidence["eigenvalue_re"][cells[rests]] = cycles.exponents[rests]
    evidence["eigenvalue_im"][cells[rests]] = 0.0
    _certify(plan, evidence, cells[closed], Certificate.CYCLE)
    evidence["period"][cells[closed]] = cycles.period[closed]
    evidence["cycle_hits"][cells[closed]] = cycles.hits[closed]
    evidence["cycle_symmetry"][cells[closed]] = cycles.symmetry[closed]
    evidence["cycle_point"][cells[closed]] = cycles.point[closed]
    evidence["multiplier_re"][cells[closed]] = cycles.multipliers[closed].real
    evidence["multiplier_im"][cells[closed]] = cycles.multipliers[closed].imag


def _certify(plan: Plan, evidence: Evidence, cells: np.ndarray, certificate: Certificate) -> None:
    """Write a certificate and its times."""
    evidence["certificate"][cells] = certificate
    evidence["certified_steps"][cells] = evidence["steps"][cells]
    evidence["settled_steps"][cells] = evidence["steps"][cells] - plan.clock.segment_steps
