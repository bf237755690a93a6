"""From shards to a result: blocks of evidence are classified, described and written."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.classify import AT_ONCE, classify, result_variables
from quavsweep.config import Sweep
from quavsweep.config.schema import ENSEMBLE
from quavsweep.errors import StoppedError
from quavsweep.horizon import truncated
from quavsweep.kernels.description import describe_model
from quavsweep.measures import REGION_VARIABLE, Evidence, Variable
from quavsweep.models import NAMES
from quavsweep.provenance import Identity
from quavsweep.reduction import (
    ATTRACTOR,
    passed_variables,
    point_dimensions,
    point_variables,
    read_variables,
    reduce_points,
)
from quavsweep.store.netcdf import Coordinate, Reduction, block_cells, write_result
from quavsweep.store.passes import blocks
from quavsweep.store.sealed_file import read_result
from quavsweep.store.shard_set import Block, ShardSet
from quavsweep.store.stored import Stored
from quavsweep.whole import TEMPORARY

DESCRIPTION = "model_description"  # attribute of the file, where the model is not of the catalogue
HORIZON = "horizon"  # attribute of the file, the time up to which it tells, where a run went on
NO_VERDICT = "no tangent vector begins at the horizon: what a run to it would call chaos is undecided"


def write_outcome(
    path: Path, shards: ShardSet, failed: Mapping[int, str], stopped: Callable[[], bool], horizon: int | None = None
) -> int:
    """Classify all evidence and publish the result file; return how many cells wait for a pass of the effort.

    Parameters
    ----------
    horizon : int, optional
        Classify as a run of so many steps would have, without what is stored of the end alone: what other measures
        recorded, the final state of cells that went on, and tangent vectors beyond the end, so that an ensemble's
        starts that a real run calls chaos are undecided. The file's attribute `horizon` tells the time.

    Raises
    ------
    DamageError
        If a shard's content is not what was published; nothing is written then.
    DiskError
        If the file cannot be written.
    StoppedError
        If `stopped()` became true, asked before each block.
    """
    sweep = shards.sweep
    earlier = horizon is not None and horizon < sweep.clock.steps
    if horizon is not None:
        sweep = sweep.until(horizon)
        shards = replace(shards, sweep=shards.sweep.without_effort())
    variables = {v: variable_attributes(sweep, v) for v in _cell_variables(sweep, horizon)}
    told = {} if horizon is None else {HORIZON: horizon * sweep.clock.dt}
    if earlier and sweep.measures.verdict:
        variables[REGION_VARIABLE] |= {"comment": NO_VERDICT}
    waiting: dict[int, int] = {}
    write_result(
        path,
        sweep.grid,
        coordinates_of(sweep),
        variables,
        _classified(shards, failed, stopped, waiting, horizon),
        {**_file(sweep, shards.identity), **told},
        block_cells(sweep.cell_bytes),
        _reduction(sweep),
    )
    return sum(waiting.values())


def _cell_variables(sweep: Sweep, horizon: int | None) -> tuple[Variable, ...]:
    """Return what is written of each cell: what the classification gives, and what is passed on from the evidence.

    At a horizon it is without what other measures recorded, which is stored of the end alone.
    """
    labels = result_variables(sweep)
    known = {variable.name for variable in labels}
    every = (*labels, *(variable for variable in passed_variables(sweep) if variable.name not in known))
    if horizon is None:
        return every
    unknown = {variable.name for variable in sweep.measures.outputs}
    return tuple(variable for variable in every if variable.name not in unknown)


def _reduction(sweep: Sweep) -> Reduction | None:
    """Return what is made of all starts of a parameter point, where there are several."""
    if not sweep.start_axes:
        return None
    return Reduction(
        sweep.points,
        {v: variable_attributes(sweep, v, of_points=True) for v in point_variables(sweep)},
        {ATTRACTOR: variable_attributes(sweep, ATTRACTOR)},
        read_variables(sweep),
        partial(reduce_points, sweep),
    )


def outcome_so_far(shards: ShardSet, horizon: int | None = None) -> Stored:
    """Return what the result file would hold if the missing tiles stayed missing, or if the run had been shorter.

    It lies in a temporary file whose name is gone already, because it may be too large for the memory.

    Raises
    ------
    DamageError
        If a shard's content is not what was published.
    DiskError
        If there is no room for temporary files.
    """
    with tempfile.TemporaryDirectory(prefix=TEMPORARY) as folder:
        path = Path(folder) / "result.h5"
        write_outcome(path, shards, {}, lambda: False, horizon)
        return read_result(path)


def _classified(
    shards: ShardSet,
    failed: Mapping[int, str],
    stopped: Callable[[], bool],
    waiting: dict[int, int],
    horizon: int | None,
) -> Iterator[tuple[Block, Mapping[str, np.ndarray]]]:
    sweep = shards.sweep
    for block, parts in blocks(shards, block_cells(sweep.cell_bytes), failed, waiting):
        if stopped():
            raise StoppedError("stopped while the result was written", possible="the same command continues it")
        if horizon is None:
            told = [_told(sweep, evidence) for evidence in _joined(parts)]
        else:
            shorter = sweep.until(horizon).without_records()
            told = [_told(shorter, truncated(sweep, evidence, horizon)) for evidence in _joined(parts)]
        yield block, {name: np.concatenate([values[name] for values in told]) for name in told[0]}


def _joined(parts: list[Evidence]) -> Iterator[Evidence]:
    """Yield evidence of neighbouring cells of small tiles together, where it reaches equally far: that is faster."""
    group: list[Evidence] = []
    for part in parts:
        cells = sum(len(other["status"]) for other in (*group, part))
        if group and (cells > AT_ONCE or _reach(group[0]) != _reach(part)):
            yield _together(group)
            group = []
        group.append(part)
    yield _together(group)


def _reach(evidence: Evidence) -> list[tuple[int, ...]]:
    """Return the shapes of a cell's evidence."""
    return [values.shape[1:] for values in evidence.values()]


def _together(group: list[Evidence]) -> Evidence:
    """Return evidence as one, without a copy where there is only one."""
    return group[0] if len(group) == 1 else {n: np.concatenate([part[n] for part in group]) for n in group[0]}


def _told(sweep: Sweep, evidence: Evidence) -> dict[str, np.ndarray]:
    """Return what is known of the cells of some evidence, or of what shards hold instead."""
    if not sweep.keeps_evidence:
        return evidence
    passed = {variable.name: evidence[variable.name] for variable in passed_variables(sweep)}
    return {**passed, **classify(sweep, evidence)}


def coordinates_of(sweep: Sweep) -> list[Coordinate]:
    """Return the coordinates of a sweep's dimensions, the axes first."""
    model = sweep.model
    coordinates = []
    for axis in sweep.grid.axes:
        if axis.along:
            meaning = "start" if axis.name == ENSEMBLE else f"point of the curve of {', '.join(axis.quantities)}"
            coordinates.append(Coordinate(axis.name, np.array(axis.values, dtype=np.int32), {"long_name": meaning}))
        for name, values in axis.quantities.items():
            quantity = model.quantity(name)
            attributes = {"long_name": quantity.meaning or name, "units": _cf(quantity.unit), "symbol": quantity.symbol}
            coordinates.append(Coordinate(name, np.array(values), attributes, axis.name))
    used = {dim for variable in (*_cell_variables(sweep, None), *point_variables(sweep)) for dim in variable.dims}
    for dimension in (*sweep.dimensions.values(), *point_dimensions()):
        if dimension.name in used:
            attributes = {"long_name": dimension.meaning}
            attributes |= {"units": _cf(dimension.unit)} if dimension.unit else {}
            attributes |= {"component_units": ", ".join(dimension.component_units)} if dimension.component_units else {}
            coordinates.append(Coordinate(dimension.name, dimension.values, attributes))
    return coordinates


def variable_attributes(sweep: Sweep, variable: Variable, of_points: bool = False) -> dict[str, Any]:
    """Return the CF attributes of a variable: meaning, units, and the codes' numbers and names."""
    unit, grid = sweep.unit(variable), sweep.points if of_points else sweep.grid
    along = [name for axis in grid.axes for name, _ in axis.along]
    attributes: dict[str, Any] = {"long_name": variable.meaning} | ({"units": _cf(unit)} if unit else {})
    attributes |= {"coordinates": " ".join(along)} if along else {}
    if variable.codes:
        attributes["flag_values"] = np.array([code.number for code in variable.codes], dtype=variable.dtype)
        attributes["flag_meanings"] = " ".join(code.name for code in variable.codes)
    return attributes


def _cf(unit: str) -> str:
    """Return a unit in the notation of the CF conventions: `N m s2/rad2` becomes `N m s2 rad-2`."""
    over, _, under = unit.partition("/")
    factors = [factor if factor[-1].isdigit() else f"{factor}1" for factor in under.split()]
    return " ".join(
        [*([] if over == "1" and factors else [over]), *(f"{factor[:-1]}-{factor[-1]}" for factor in factors)]
    )


def _file(sweep: Sweep, identity: Identity) -> dict[str, str]:
    """Return the attributes of the file; names, folders, times and machines are in none of them."""
    own = {} if sweep.model.name in NAMES else {DESCRIPTION: describe_model(sweep.model)}
    return {
        "Conventions": "CF-1.11",
        "title": f"quavsweep result: {sweep.model.name}",
        "source": sweep.model.source,
        "model": sweep.model.name,
        "config": json.dumps(sweep.settings()),
        "evidence_id": identity.evidence,
        "toolchain_id": identity.toolchain,
        "result_id": identity.result,
        **own,
    }
