"""Evidence to regions: pure NumPy on what is stored, so thresholds can change without a new integration.

Windows of time are whole segments, because the total growth is stored at their ends. The rules:

- sink: the certificate says so; its exponents are the real parts of the eigenvalues, without error;
- unbounded: the orbit left the model's bound;
- saddle: the orbit sits on an equilibrium with an eigenvalue to the right of zero;
- chaos: the largest exponent is positive beyond its error in the last half and in the last quarter of the duration;
- periodic: it is neutral in both;
- undecided: anything else.

An exponent L over a time T is positive if L > max(`errors` standard errors, `neutral` / T), and neutral if
|L| <= `neutral` / T: along a bounded orbit ln of the growth in the direction of the flow stays bounded, so the
neutral exponent falls as 1/T. A large error never makes an exponent neutral, nor does a time so short that
`neutral` / T is not small against the other exponents.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from quavsweep.codes import Certificate, Region, Status
from quavsweep.config import Sweep
from quavsweep.measures import REGION_VARIABLE, STATUS_VARIABLE, Evidence, Variable

TELLING = 0.1  # what counts as zero must be this small against the largest exponent in size
LARGEST = slice(0, 1)  # of the exponents
FEWEST_BATCHES = 4  # below so many a standard error means nothing
AT_ONCE = 1024  # cells, so that what is computed on the way stays small and near the processor

_STATE = (
    Variable("settle_time", (), "float64", "time", "last look outside the certified neighbourhood, from t = 0"),
    Variable("time_used", (), "float64", "time", "time integrated, from t = 0"),
    Variable("final_state", ("state",), "float64", "state", "state at the end"),
    Variable("equilibrium", ("state",), "float64", "state", "equilibrium in which the orbit ends"),
    Variable("eigenvalue_re", ("eigenvalue",), "float64", "1/time", "real parts of the eigenvalues there"),
    Variable("eigenvalue_im", ("eigenvalue",), "float64", "1/time", "imaginary parts of the eigenvalues there"),
)
_LYAPUNOV = (
    Variable("lyapunov", ("exponent",), "float64", "1/time", "Lyapunov exponents, exact where certified"),
    Variable("lyapunov_raw", ("exponent",), "float64", "1/time", "Lyapunov exponents averaged after the transient"),
    Variable("lyapunov_se", ("exponent",), "float64", "1/time", "standard error of lyapunov, 0 where certified"),
    Variable("was_chaotic", (), "int8", "1", "whether the orbit was chaotic at some time (1) or not (0)"),
)


def result_variables(sweep: Sweep) -> tuple[Variable, ...]:
    """Return what `classify` gives for each cell of a sweep."""
    lyapunov = _LYAPUNOV if sweep.measures.lyapunov else ()
    return (REGION_VARIABLE, STATUS_VARIABLE, *lyapunov, *_STATE, *sweep.measures.outputs)


def classify(sweep: Sweep, evidence: Evidence) -> dict[str, np.ndarray]:
    """Return region, exponents and times of the cells of some evidence.

    Parameters
    ----------
    sweep : Sweep
        For its clock and thresholds.
    evidence : dict of (n, ...) arrays

    Returns
    -------
    dict of (n, ...) arrays, one per variable of `result_variables`.
    """
    n = len(evidence["status"])
    result = {v.name: np.empty(v.shape(n, sweep.extents), v.dtype) for v in result_variables(sweep)}
    for cells, part in _parts(evidence):
        values = _described(sweep, part)
        for name, array in result.items():
            array[cells] = values[name]
    return result


def regions(sweep: Sweep, evidence: Evidence) -> np.ndarray:
    """Return only the region of each cell, (n,) int8; it costs a fraction of the rest."""
    found = [_region(sweep, part, _Exponents(sweep, part)) for _, part in _parts(evidence)]
    return np.concatenate([np.zeros(0, np.int8), *found])


def undecided(sweep: Sweep, evidence: Evidence) -> np.ndarray:
    """Return which cells are undecided, (n,) bool."""
    return np.asarray(regions(sweep, evidence) == Region.UNDECIDED)


def _parts(evidence: Evidence) -> Iterator[tuple[slice, Evidence]]:
    """Yield a few cells at a time, and which they are."""
    for first in range(0, len(evidence["status"]), AT_ONCE):
        cells = slice(first, first + AT_ONCE)
        yield cells, {name: values[cells] for name, values in evidence.items()}


def _described(sweep: Sweep, evidence: Evidence) -> dict[str, np.ndarray]:
    """Return everything that is known of cells."""
    sink = evidence["certificate"] == Certificate.SINK
    exponents = _Exponents(sweep, evidence)
    region = _region(sweep, evidence, exponents)
    dt = sweep.clock.dt
    result = {
        "region": region,
        "status": evidence["status"],
        "time_used": evidence["steps"] * dt,
        "settle_time": np.where(sink, evidence["settled_steps"] * dt, np.nan),
        "final_state": evidence["state"],
        "equilibrium": evidence["equilibrium"],
        "eigenvalue_re": evidence["eigenvalue_re"],
        "eigenvalue_im": evidence["eigenvalue_im"],
        **{variable.name: evidence[variable.name] for variable in sweep.measures.outputs},
    }
    if sweep.measures.lyapunov:
        result |= _lyapunov(exponents, evidence, sink)
        result["was_chaotic"] = exponents.was_chaotic | (region == Region.CHAOS)
    return result


def _region(sweep: Sweep, evidence: Evidence, exponents: _Exponents) -> np.ndarray:
    """Return the region of each cell, (n,) int8."""
    status, certificate = evidence["status"], evidence["certificate"]
    computed = (status != Status.NOT_COMPUTED) & (status != Status.FAILED)
    region = np.where(computed, Region.UNDECIDED, Region.NONE).astype(np.int8)
    if sweep.measures.lyapunov:
        over = status == Status.TIME_OVER
        region[over & exponents.chaotic] = Region.CHAOS
        region[over & exponents.periodic] = Region.PERIODIC
    resting = certificate == Certificate.REST
    region[resting & (evidence["eigenvalue_re"][:, 0] > 0)] = Region.SADDLE
    region[resting & ~(evidence["eigenvalue_re"][:, 0] > 0)] = Region.UNDECIDED
    region[status == Status.DIVERGED] = Region.UNBOUNDED
    region[certificate == Certificate.SINK] = Region.SINK
    return region


def _lyapunov(exponents: _Exponents, evidence: Evidence, sink: np.ndarray) -> dict[str, np.ndarray]:
    """Return raw exponents, and those that certificates replaced, with errors."""
    raw, error = exponents.average(exponents.transient, exponents.used)
    exact = evidence["eigenvalue_re"][:, : raw.shape[1]]
    return {
        "lyapunov": np.where(sink[:, None], exact, raw),
        "lyapunov_raw": raw,
        "lyapunov_se": np.where(sink[:, None], 0.0, error),
    }


def convergence(sweep: Sweep, evidence: Evidence) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how averages grow with time.

    Returns
    -------
    until : (n, m) float64
        Times from t = 0, the end of each segment after the transient (of all where a cell ended within it), as far
        as the cell that was integrated longest.
    exponents, errors : (n, m, K) float64
        Averages until then and their standard errors; NaN beyond a cell's end.
    """
    averages = _Exponents(sweep, evidence)
    used = averages.used
    first = np.where(used > averages.transient, averages.transient, 0)
    ends = [np.minimum(first + i, used) for i in range(1, int((used - first).max(initial=0)) + 1)]
    pairs = [averages.average(np.where(first + i > used, used, first), end) for i, end in enumerate(ends, 1)]
    length = sweep.clock.segment_steps * sweep.clock.dt
    if not pairs:
        n, k = evidence["growth_total"].shape[::2]
        return np.zeros((n, 0)), np.zeros((n, 0, k)), np.zeros((n, 0, k))
    exponents, errors = (np.stack(part, axis=1) for part in zip(*pairs, strict=True))
    return np.stack(ends, axis=1) * length, exponents, errors


class Sums:
    """Running sums over batches, from which the standard error over any window follows at once.

    Growth that one batch has too much the next one lacks, because the frame's lag behind the flow is bounded; so the
    variance of the mean is that of independent batches plus twice the covariance of neighbours, but at least a
    quarter of the former, since a covariance from few batches is itself uncertain.

    Parameters
    ----------
    rates : (n, batches, K) float64
        Mean rate of growth in each batch; NaN where there is none.
    """

    def __init__(self, rates: np.ndarray) -> None:
        self._rates = np.nan_to_num(np.ascontiguousarray(np.moveaxis(rates, 1, 0), dtype=np.float64))
        self._first = _running(self._rates)
        self._second = _running(self._rates * self._rates)
        self._product = _running(self._rates[1:] * self._rates[:-1])

    def error(self, first: np.ndarray, last: np.ndarray, exponents: slice = slice(None)) -> np.ndarray:
        """Return the standard error of the mean over the batches first .. last - 1 of each cell.

        Returns
        -------
        (n, K) float64, infinite where the window has fewer than four batches; fewer columns if `exponents` says so
        """
        cells = np.arange(len(first))
        last = np.maximum(last, first + 1)
        count = (last - first)[:, None]
        total = self._first[last, cells, exponents] - self._first[first, cells, exponents]
        mean = total / count
        squares = self._second[last, cells, exponents] - self._second[first, cells, exponents] - mean * total
        products = self._product[last - 1, cells, exponents] - self._product[first, cells, exponents]
        ends = self._rates[first, cells, exponents] + self._rates[last - 1, cells, exponents]
        products += mean * ends - mean * mean * (count + 1)
        floor = np.maximum(squares, 0.0) / 4.0
        error = np.sqrt(np.maximum(squares + 2.0 * products, floor) / np.maximum(count - 1, 1) / count)
        return np.where(count < FEWEST_BATCHES, np.inf, error)


def _running(values: np.ndarray) -> np.ndarray:
    """Return sums over axis 0 up to, and without, each index; one longer than the values."""
    sums = np.concatenate([np.zeros_like(values[:1]), values])
    for i in range(1, len(values)):  # several times as fast as `cumsum`, which goes cell by cell
        sums[i + 1] += sums[i]
    return sums


@dataclass(frozen=True)
class _Exponents:
    """Averages of the stored growth over windows of whole segments, per cell."""

    sweep: Sweep
    evidence: Evidence

    @property
    def used(self) -> np.ndarray:
        """Segments integrated with finite growth, (n,); none where the orbit diverged or the frame degenerated."""
        status = self.evidence["status"]
        bad = (status == Status.DIVERGED) | (status == Status.FRAME_DEGENERATE)
        return np.where(bad, 0, self.evidence["steps"] // self.sweep.clock.segment_steps)

    @property
    def transient(self) -> np.ndarray:
        """Segments before averaging begins, (n,)."""
        return np.full(self.evidence["status"].shape, self.sweep.clock.transient_segments)

    def average(self, first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return exponents over the segments first .. last - 1 and their standard errors, (n, K) each.

        NaN where the window is empty.
        """
        return self._rates(first, last), self._errors(first, last)

    def _rates(self, first: np.ndarray, last: np.ndarray, exponents: slice = slice(None)) -> np.ndarray:
        clock, total = self.sweep.clock, self.evidence["growth_total"]
        cells = np.arange(total.shape[0])
        empty = last <= first
        end = np.where(empty[:, None], np.nan, total[cells, np.maximum(last, 1) - 1, exponents])
        begin = np.where((first > 0)[:, None], total[cells, np.maximum(first, 1) - 1, exponents], 0.0)
        span = np.where(empty, 1, last - first)[:, None] * clock.segment_steps * clock.dt
        return np.asarray((end - begin) / span)

    def _errors(self, first: np.ndarray, last: np.ndarray, exponents: slice = slice(None)) -> np.ndarray:
        batches = self.sweep.clock.segment_batches
        errors = self._sums.error(first * batches, last * batches, exponents)
        return np.where((last <= first)[:, None], np.nan, errors)

    @cached_property
    def _sums(self) -> Sums:
        clock = self.sweep.clock
        return Sums(self.evidence["growth"].astype(np.float64) / (clock.batch_steps * clock.dt))

    def positive(self, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """Whether the largest exponent is positive beyond its error over a window, (n,) bool."""
        errors = self._errors(first, last, LARGEST)[:, 0]
        limit = np.maximum(self.sweep.config.classify.errors * errors, self._zero(first, last))
        return np.asarray(self._rates(first, last, LARGEST)[:, 0] > limit)

    def neutral(self, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        """Whether the largest exponent is zero, and the window long enough to tell, (n,) bool."""
        rates, zero = self._rates(first, last), self._zero(first, last)
        told = (zero <= TELLING * np.abs(rates).max(axis=1)) | (rates.shape[1] == 1)
        return np.asarray(told & (np.abs(rates[:, 0]) <= zero))

    def _zero(self, first: np.ndarray, last: np.ndarray) -> np.ndarray:
        clock = self.sweep.clock
        time = np.maximum(last - first, 1) * clock.segment_steps * clock.dt
        return np.asarray(self.sweep.config.classify.neutral / time)

    def _ends(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return the last half and the last quarter of the duration."""
        length = self.used - self.transient
        return [(self.used - np.maximum(length // part, 1), self.used) for part in (2, 4)]

    @property
    def chaotic(self) -> np.ndarray:
        """Positive in the last half and the last quarter, (n,) bool."""
        half, quarter = self._ends()
        return np.asarray(self.positive(*half) & self.positive(*quarter))

    @property
    def periodic(self) -> np.ndarray:
        """Neutral in the last half and the last quarter, (n,) bool."""
        half, quarter = self._ends()
        return np.asarray(self.neutral(*half) & self.neutral(*quarter))

    @property
    def was_chaotic(self) -> np.ndarray:
        """Positive over some time from the second segment on, and still in the second half of that time, (n,) bool.

        The first segment is left out, for a start near a saddle grows once. Where the orbit settled, only the time
        before counts.
        """
        steps = self.sweep.clock.segment_steps
        settled = self.evidence["certificate"] == Certificate.SINK
        limit = np.where(settled, self.evidence["settled_steps"] // steps, self.used)
        first = np.ones_like(limit)
        found = np.zeros(limit.shape, dtype=bool)
        for last in range(3, int(limit.max(initial=0)) + 1):
            end = np.full_like(limit, last)
            half = first + (end - first) // 2
            found |= (last <= limit) & self.positive(first, end) & self.positive(half, end)
        return found
