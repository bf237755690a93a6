"""From cells to parameter points: what all starts together say of a point's attractors, basins and lifetimes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from quavsweep.analysis.attractor import MOST, OTHER, find_attractors
from quavsweep.analysis.exact import exact_exponents
from quavsweep.analysis.lifetime import (
    Survival,
    constancy,
    least_residual,
    mean_residual,
    outlasts,
    settled_look,
    share_error,
    spiral_time,
)
from quavsweep.codes import CERTIFICATE, REGION, Certificate, Region, Status
from quavsweep.config import Sweep
from quavsweep.measures import Dimension, Variable

KINDS = tuple(code for code in REGION if code.number != Region.NONE)
ATTRACTOR = Variable("attractor", (), "int8", "1", f"number in the table of its point, 0 for none, {OTHER} for another")
_POINTS = (
    Variable("starts", (), "int32", "1", "starts that are computed"),
    Variable("basin_share", ("kind",), "float64", "1", "share of the starts that end so"),
    Variable("basin_share_se", ("kind",), "float64", "1", "standard error of basin_share (Agresti and Coull)"),
    Variable("attractor_kind", ("attractor_number",), "int8", "1", "what the attractor is", CERTIFICATE),
    Variable("attractor_point", ("attractor_number", "state"), "float64", "state", "a point on the attractor"),
    Variable(
        "attractor_exponents", ("attractor_number", "eigenvalue"), "float64", "1/time", "Lyapunov exponents on it"
    ),
    Variable("attractor_share", ("attractor_number",), "float64", "1", "share of the starts that end in it"),
    Variable(
        "attractor_share_se", ("attractor_number",), "float64", "1", "standard error of the share (Agresti and Coull)"
    ),
)
_LIFETIMES = (
    Variable("lifetime_after", (), "float64", "time", "time from which on leaving is exponential; direct starts left"),
    Variable("chaotic_share", (), "float64", "1", "share of the starts that are still chaotic then"),
    Variable("chaotic_share_se", (), "float64", "1", "standard error of chaotic_share (Agresti and Coull)"),
    Variable(
        "lifetime",
        (),
        "float64",
        "time",
        "their mean lifetime, from t = 0; NaN where fewer than 10 leave, or all as if directly",
    ),
    Variable("lifetime_se", (), "float64", "time", "standard error of lifetime"),
    Variable("lifetime_at_least", (), "float64", "time", "bound that the mean lifetime exceeds with confidence 95 %"),
    Variable("lifetime_p", (), "float64", "1", "probability of such a departure from exponential leaving by chance"),
)
# What of a cycle the table needs, taken from the evidence as it is.
PASSED = ("period", "cycle_point", "multiplier_re", "multiplier_im")
_READ = ("region", "status", "time_used", "settle_time", "final_state", "equilibrium", "eigenvalue_re", *PASSED)


def point_variables(sweep: Sweep) -> tuple[Variable, ...]:
    """Return what `reduce_points` gives for each parameter point; nothing without axes over starts."""
    if not sweep.start_axes:
        return ()
    return (*_POINTS, *(_LIFETIMES if sweep.config.ensemble else ()))


def point_dimensions() -> tuple[Dimension, ...]:
    """Return the dimensions of its results that cells do not have."""
    names = np.array([code.name for code in KINDS], dtype=object)
    numbers = np.arange(1, MOST + 1, dtype=np.int32)
    return (
        Dimension("kind", names, "what the orbit does in the end"),
        Dimension(
            "attractor_number",
            numbers,
            "number of the attractor: sinks, then cycles, each in ascending order of the points",
        ),
    )


def passed_variables(sweep: Sweep) -> tuple[Variable, ...]:
    """Return the variables of the evidence that cells need in the result, so that points can be made of them."""
    return tuple(v for v in sweep.measures.evidence if v.name in PASSED) if sweep.start_axes else ()


def read_variables(sweep: Sweep) -> tuple[str, ...]:
    """Return the names of what `reduce_points` reads of cells."""
    return _READ


def reduce_points(sweep: Sweep, cells: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return what the starts of some parameter points say together.

    Parameters
    ----------
    cells : mapping of (points, starts, ...) arrays
        See `read_variables`.

    Returns
    -------
    dict of (points, ...) arrays, one per variable of `point_variables`, and `attractor`, (points, starts) int8.
    """
    points, starts = cells["region"].shape
    extents = {dimension.name: len(dimension) for dimension in (*sweep.dimensions.values(), *point_dimensions())}
    result = {v.name: v.empty(points, extents) for v in point_variables(sweep)}
    result["attractor"] = np.zeros((points, starts), dtype=np.int8)
    for i in range(points):
        cell = {name: values[i] for name, values in cells.items()}
        total = int((cell["region"] != Region.NONE).sum())
        found = {"starts": total, **_basins(cell, total), **_attractors(sweep, cell, total)}
        if sweep.config.ensemble:
            segment = sweep.clock.segment_steps * sweep.clock.dt
            found |= lifetimes(cell, total, segment, _direct_time(sweep, cell, segment), _decay_time(sweep, cell))
        for name, values in found.items():
            result[name][i] = values
    return result


def _basins(cell: Mapping[str, np.ndarray], total: int) -> dict[str, np.ndarray]:
    """Return the shares of starts that end as a sink, cycle, chaos ..."""
    count = np.bincount(cell["region"], minlength=len(REGION))[[code.number for code in KINDS]]
    share = count / total if total else np.full(len(KINDS), np.nan)
    return {"basin_share": share, "basin_share_se": share_error(count, np.full(len(KINDS), total))}


def _certificates(cell: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return in what each start is known to end, (starts,) int: a certified sink or cycle."""
    cycle = (cell["region"] == Region.PERIODIC) & np.isfinite(cell["cycle_point"]).all(axis=1)
    sink = np.where(cell["region"] == Region.SINK, Certificate.SINK, Certificate.NONE)
    return np.where(cycle, Certificate.CYCLE, sink)


def _attractors(sweep: Sweep, cell: Mapping[str, np.ndarray], total: int) -> dict[str, np.ndarray]:
    """Return the table of attractors, rows beyond its end empty, and the number of each start's."""
    kind = _certificates(cell)
    on_cycle = (kind == Certificate.CYCLE)[:, None]
    table = find_attractors(kind, np.where(on_cycle, cell["cycle_point"], cell["equilibrium"]))
    rows, size = slice(len(table.kind)), len(sweep.model.states)
    result = {
        "attractor": table.number,
        "attractor_kind": np.zeros(MOST, dtype=np.int8),
        "attractor_point": np.full((MOST, size), np.nan),
        "attractor_exponents": np.full((MOST, size), np.nan),
        "attractor_share": np.full(MOST, np.nan),
        "attractor_share_se": np.full(MOST, np.nan),
    }
    result["attractor_kind"][rows] = table.kind
    result["attractor_point"][rows] = table.point
    ends = {name: cell[name][table.first] for name in _READ}
    result["attractor_exponents"][rows] = exact_exponents({**ends, "certificate": table.kind})
    if total:
        result["attractor_share"][rows] = table.count / total
        result["attractor_share_se"][rows] = share_error(table.count, np.full(len(table.count), total))
    return result


def survival_of(cell: Mapping[str, np.ndarray], segment: float) -> tuple[Survival, np.ndarray]:
    """Return the survival of the starts of a point, and the last look at which each of them was outside.

    Leaving is to reach a certified attractor or the bound of the model. Starts that stay but are known not to be
    chaotic, such as those that sit on a saddle, do not count.

    Parameters
    ----------
    cell : mapping of (starts,) arrays
    segment : float
        Time between two looks.
    """
    region, settled = cell["region"], np.isfinite(cell["settle_time"])
    unbounded = region == Region.UNBOUNDED
    staying = ((region == Region.CHAOS) | (region == Region.UNDECIDED)) & ~settled
    used = np.rint(cell["time_used"] / segment)
    stayed = np.where(settled, np.rint(np.nan_to_num(cell["settle_time"]) / segment), used - unbounded).astype(np.int64)
    counted = settled | unbounded | staying
    return Survival.of(np.maximum(stayed[counted], 0), ~staying[counted]), stayed[counted]


def _direct_time(sweep: Sweep, cell: Mapping[str, np.ndarray], segment: float) -> float:
    """Return the time that a start of a point needs at most to spiral into a sink directly, by those that ended there.

    Starts that went on have a last state that tells nothing, and at a horizon none.
    """
    sink = cell["status"] == Status.ENDED_SINK
    late = np.maximum(cell["time_used"] - cell["settle_time"] - segment, 0.0)[sink]
    rate = -cell["eigenvalue_re"][sink, 0]
    return spiral_time(sweep.starts[sink], cell["final_state"][sink], cell["equilibrium"][sink], rate, late)


def _decay_time(sweep: Sweep, cell: Mapping[str, np.ndarray]) -> float:
    """Return the mean over the starts of a point of 1 / the slowest rate of decay onto where they end; 0 without any.

    The largest exponent of a sink is that rate, and the second of a cycle, along which nothing decays, unless it is
    forced.
    """
    kind = _certificates(cell)
    exponents = exact_exponents({**cell, "certificate": kind})
    second = (kind == Certificate.CYCLE) & (sweep.model.forcing_period is None)
    rate = -exponents[np.arange(len(kind)), second.astype(int)]
    known = rate > 0
    return float(np.mean(1.0 / rate[known])) if known.any() else 0.0


def lifetimes(
    cell: Mapping[str, np.ndarray], total: int, segment: float, direct: float = 0.0, decay: float = 0.0
) -> dict[str, float]:
    """Return the mean lifetime of the starts of a point that are chaotic beyond the time of the direct ones.

    Parameters
    ----------
    cell : mapping of (starts,) arrays
    total : int
        Starts that are computed.
    segment : float
        Time between two looks.
    direct : float
        Time that a direct start needs at most.
    decay : float
        Time of the slowest decay onto the attractors.

    Notes
    -----
    Starts that come down directly do not all take the same time: one that begins e times as far away takes one time of
    decay longer, so their last ones leave with a mean residual of about one such time. Only a mean residual, or where
    it is not known its bound, of three or more (see `outlasts`) is chaos; else there is no lifetime.
    """
    survival, stayed = survival_of(cell, segment)
    first = settled_look(survival, direct / segment)
    beyond, chaotic = survival.beyond(first), int((stayed >= first).sum())
    mean, error = mean_residual(beyond)
    least = least_residual(beyond)
    after = first * segment
    if not outlasts(mean if np.isfinite(mean) else least, decay / segment):
        mean = error = least = np.nan
    return {
        "lifetime_after": after if total else np.nan,
        "chaotic_share": chaotic / total if total else np.nan,
        "chaotic_share_se": float(share_error(np.array(chaotic), np.array(total))),
        "lifetime": after + mean * segment,
        "lifetime_se": error * segment,
        "lifetime_at_least": after + least * segment,
        "lifetime_p": constancy(beyond) if np.isfinite(mean) else np.nan,
    }
