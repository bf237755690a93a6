"""Comparing two results, a box of cells at a time, so that they may be larger than the memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.codes import REGION, STATUS, Region
from quavsweep.difference.common import Box, Common, find_common
from quavsweep.difference.identical import differing_variables, same_bytes, same_content, same_data
from quavsweep.difference.move import FARTHEST, Move, Moved, Mover, changes
from quavsweep.errors import ConfigError
from quavsweep.provenance import changes_evidence, differing
from quavsweep.result import Result, open_result


@dataclass(frozen=True)
class Change:
    """Cells that went from one region to another: the names of both, and how many."""

    before: str
    after: str
    cells: int


@dataclass(frozen=True)
class Difference:
    """What differs between two results, the first and the second.

    Parameters
    ----------
    identical : str
        How much is the same: `bytes` of files, `content` (data and attributes), `data` of all variables; or nothing.
    cells : (int, int)
        Of each.
    common : int
        That are in both.
    compared : int
        That are computed in both, too; what follows is of these.
    same : int
        Whose region is the same.
    changes : tuple of Change
        The others, most cells first.
    moves : tuple of Move
        How far each exponent moved where the region is the same; none without exponents in both.
    farthest : tuple of Moved
        The few of these cells in which one moved farthest.
    status : dict
        From a status that occurs among the cells in common to how many have it in each.
    config : dict
        From a dotted key that differs to its values, None where it is not there.
    variables : dict
        From a variable of both that differs to the number of cells, or parameter points, in which its bits do.
    alone : (tuple, tuple) of str
        Variables that only one of them has.
    evidence, toolchain : bool
        Whether the evidence (config, equations, engine), and compilers and libraries, are the same.
    engine : bool
        Whether equations and engine are; where keys of the config differ that change evidence it cannot be told, and
        they count as the same.
    """

    identical: str
    cells: tuple[int, int]
    common: int
    compared: int
    same: int
    changes: tuple[Change, ...]
    moves: tuple[Move, ...]
    farthest: tuple[Moved, ...]
    status: dict[str, tuple[int, int]]
    config: dict[str, tuple[Any, Any]]
    variables: dict[str, int]
    alone: tuple[tuple[str, ...], tuple[str, ...]]
    evidence: bool
    toolchain: bool
    engine: bool

    @property
    def changed(self) -> int:
        """How many cells changed region."""
        return self.compared - self.same

    def to_json(self) -> dict[str, Any]:
        """Return it as data for other programs; what has no number is None."""
        return {**_plain(asdict(self)), "changed": self.changed}


def _plain(value: Any) -> Any:
    """Return data with None for what is no finite number, which JSON does not have."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def compare_results(a: Result | Path | str, b: Result | Path | str) -> Difference:
    """Return what differs between two results, at the cells that both have.

    Parameters
    ----------
    a, b : Result or Path
        Of a path what `open_result` gives: the result of a file or a run's folder, or what an unfinished one has.

    Raises
    ------
    ConfigError
        If there is nothing to open, the axes are others, or no cell is in both.
    DamageError
        If what is stored is not what was written.
    """
    opened = [source if isinstance(source, Result) else open_result(source) for source in (a, b)]
    difference = compare(find_common(*opened))
    if isinstance(a, Result) or isinstance(b, Result):
        return difference
    return told_of_files(difference, opened, (Path(a), Path(b)))


def told_of_files(difference: Difference, results: Sequence[Result], paths: Sequence[Path]) -> Difference:
    """Return the difference of two results with what is known of the files that they were opened from."""
    same = "bytes" if same_bytes(*paths) else difference.identical
    # What a file from elsewhere says of itself is no proof, but that its data are the same has been seen.
    believed = same == "data" or not any(result.stored.foreign for result in results)
    return replace(difference, identical="content" if same != "bytes" and believed and same_content(*results) else same)


def compare(common: Common) -> Difference:
    """Return what differs at the cells that two results have in common.

    Raises
    ------
    ConfigError
        If one of them has no regions.
    """
    a, b = common.a, common.b
    if "region" not in a or "region" not in b:
        raise ConfigError(
            "a file without regions cannot be compared", possible="name a result.h5 or the folder of a run"
        )
    kept, went, status = _Kept(common), np.zeros((len(REGION),) * 2, dtype=np.int64), np.zeros((2, len(STATUS)), int)
    for box in common.boxes():
        before, after = common.read("region", box)
        np.add.at(went, (before, after), 1)
        status += [np.bincount(codes, minlength=len(STATUS)) for codes in common.read("status", box)]
        kept.add(box, before, (before == after) & (before != Region.NONE))
    known = went[1:, 1:]
    varying = differing_variables(common)
    ids = [result.stored.file_attributes for result in (a, b)]
    same_evidence, config = ids[0]["evidence_id"] == ids[1]["evidence_id"], differing(_settings(a), _settings(b))
    told = any(changes_evidence(result.sweep, key) for result in (a, b) for key in config)
    return Difference(
        identical="data" if same_data(common, varying) else "",
        cells=(a.sweep.grid.size, b.sweep.grid.size),
        common=common.grid.size,
        compared=int(known.sum()),
        same=int(np.trace(known)),
        changes=_changes(went),
        moves=kept.moves,
        farthest=tuple(kept.farthest),
        status={code.name: (int(n), int(m)) for code, n, m in zip(STATUS, *status, strict=True) if n or m},
        config=config,
        variables=varying,
        alone=(_alone(a, b), _alone(b, a)),
        evidence=same_evidence,
        toolchain=ids[0]["toolchain_id"] == ids[1]["toolchain_id"],
        engine=same_evidence or told,
    )


def _changes(went: np.ndarray) -> tuple[Change, ...]:
    """Return the changes of region of cells that are computed in both, most cells first."""
    pairs = [(i, j) for i, j in np.argwhere(went) if i != j and Region.NONE not in (i, j)]
    found = [Change(REGION[i].name, REGION[j].name, int(went[i, j])) for i, j in pairs]
    return tuple(sorted(found, key=lambda change: -change.cells))


def _settings(result: Result) -> dict[str, Any]:
    """Return what was asked for, with the horizon, if it is seen at one."""
    return result.sweep.settings() | ({} if result.horizon is None else {"horizon": result.horizon})


def _alone(a: Result, b: Result) -> tuple[str, ...]:
    return tuple(name for name in a.variables if name not in b)


class _Kept:
    """Gathers how far exponents moved where the region is the same, and the cells in which they moved farthest."""

    def __init__(self, common: Common) -> None:
        self.common = common
        both = all("lyapunov" in result for result in (common.a, common.b))
        exponents = min(result.sweep.extents["exponent"] for result in (common.a, common.b)) if both else 0
        self.movers = [Mover() for _ in range(exponents)]
        self.farthest: list[Moved] = []

    @property
    def moves(self) -> tuple[Move, ...]:
        """How far each exponent moved."""
        return tuple(mover.told(k) for k, mover in enumerate(self.movers, 1))

    def add(self, box: Box, region: np.ndarray, same: np.ndarray) -> None:
        """Take a box in, of whose cells only those count whose region is the same, (n,) bool."""
        if not self.movers or not same.any():
            return
        number = len(self.movers)
        read = [self.common.read(name, box) for name in ("lyapunov", "lyapunov_se")]
        change, error, missing = changes(*(values[same, :number] for pair in read for values in pair))
        for k, mover in enumerate(self.movers):
            mover.add(change[:, k], error[:, k], missing[:, k])
        size = np.where(np.isfinite(change), np.abs(change), 0.0)
        first = np.argsort(-size.max(axis=1), kind="stable")[:FARTHEST]
        rows = first[size[first].max(axis=1) > 0]
        found = self._told(self.common.cells(box)[same][rows], region[same][rows], change[rows], error[rows])
        self.farthest = sorted([*self.farthest, *found], key=lambda moved: -abs(moved.change))[:FARTHEST]

    def _told(self, cells: np.ndarray, region: np.ndarray, change: np.ndarray, error: np.ndarray) -> list[Moved]:
        """Return cells, each with the exponent that moved farthest."""
        values, found = self.common.grid.coordinates_of(cells), []
        for i in range(len(cells)):
            k = int(np.argmax(np.where(np.isfinite(change[i]), np.abs(change[i]), -1.0)))
            at = {name: float(values[name][i]) for name in self.common.grid.quantities}
            measured = 0 < error[i, k] < np.inf
            in_errors = float(abs(change[i, k]) / error[i, k]) if measured else np.nan
            found.append(Moved(at, REGION[region[i]].name, k + 1, float(change[i, k]), in_errors))
        return found
