"""A result's variables for other programs: a table of text, or a netCDF file of its own."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import numpy as np

from quavsweep.codes import REGION
from quavsweep.difference import Common
from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest
from quavsweep.result import Result
from quavsweep.store import Part, block_cells, write_copy


def write_csv(result: Result, names: Sequence[str], stream: IO[str]) -> None:
    """Write variables as a table: axes first, and a column for each component of a variable.

    There is a row per cell, or per parameter point where all variables are of points. If one of them has two dimensions
    beyond the axes, such as the points of attractors, there is a row for each number of the first of them.

    Codes are written as their names, and nothing where there is no number.

    Raises
    ------
    ConfigError
        If a variable does not exist, or they do not fit into one table.
    """
    table = csv.writer(stream, lineterminator="\n")
    result, inner = _rows(result, names)
    grid, labels = result.sweep.grid, np.asarray(result[inner] if inner else [0])
    headers = [header for name in names for header in _headers(result, name, inner)]
    table.writerow([*grid.coordinates(0, 1), *([inner] if inner else []), *headers])
    for block in grid.blocks(block_cells(result.sweep.cell_bytes)):
        start, stop = grid.span(block)
        axes = [_texts(np.repeat(values, len(labels))) for values in grid.coordinates(start, stop).values()]
        axes += [_texts(np.tile(labels, stop - start))] if inner else []
        rows = (stop - start) * len(labels)
        columns = [_texts(column) for name in names for column in _columns(result, name, block, rows)]
        table.writerows(zip(*axes, *columns, strict=True))


def write_changes(common: Common, stream: IO[str]) -> None:
    """Write the cells that changed region as a table: axes, and region and exponents of both results.

    Cells that are not computed in one of them are left out. Codes and numbers are written as by `write_csv`.
    """
    table, pair, region = csv.writer(stream, lineterminator="\n"), (common.a, common.b), "region"
    exponents = [result["exponent"] if "lyapunov" in result else () for result in pair]
    rates = [f"lyapunov_{k}_{side}" for own, side in zip(exponents, "ab", strict=True) for k in own]
    table.writerow([*common.grid.coordinates(0, 1), "region_a", "region_b", *rates])
    names = np.array([code.name for code in REGION])
    for box in common.boxes():
        codes = common.read(region, box)
        changed = np.flatnonzero((codes[0] != codes[1]) & (codes[0] > 0) & (codes[1] > 0))
        columns = [
            *common.grid.coordinates_of(common.cells(box)[changed]).values(),
            *(names[c[changed]] for c in codes),
        ]
        for side, own in enumerate(exponents):
            columns += [*common.read_one(side, "lyapunov", box)[changed].T] if len(own) else []
        table.writerows(zip(*(_texts(column) for column in columns), strict=True))


def write_netcdf(result: Result, names: Sequence[str], path: Path) -> None:
    """Write variables, with their coordinates, as a netCDF-4 file.

    Raises
    ------
    ConfigError
        If a variable does not exist.
    DiskError
        If the file cannot be written.
    """
    for name in names:
        _check(result, name)
    stored = result.stored
    dims = {dim for name in names for dim in stored.dims[name]}
    along = {name for axis in result.sweep.grid.axes if axis.name in dims for name, _ in axis.along}
    kept = {*names, *dims, *along}
    write_copy(stored, kept, path)


def _check(result: Result, name: str) -> None:
    if name not in result:
        what = f"there is no variable {name}{nearest(name, result.variables)}"
        raise ConfigError(what, possible=f"there are {', '.join(result.variables)}")


def _rows(result: Result, names: Sequence[str]) -> tuple[Result, str]:
    """Return the result over the axes of a table's rows, and the dimension inside them; empty if there is none."""
    for name in names:
        _check(result, name)
        if name not in result.variables:
            raise ConfigError(f"{name} is no variable of cells", possible="it stands beside each of them")
    points = result.points
    if result.sweep.start_axes and all(name in points for name in names):
        result = points
    axes = tuple(axis.name for axis in result.sweep.grid.axes)
    extra = {name: _extra(result, name, axes) for name in names}
    inner = next((dims[0] for dims in extra.values() if len(dims) == 2), "")
    for name, dims in extra.items():
        if len(dims) > 2 or (inner and dims[:1] != (inner,)):
            raise _unfit(name, f"each cell{f' and {inner}' if inner else ''}")
    return result, inner


def _extra(result: Result, name: str, axes: tuple[str, ...]) -> tuple[str, ...]:
    """Return the dimensions of a variable beyond the axes."""
    dims = result.stored.dims[name]
    if dims[: len(axes)] != axes:
        raise _unfit(name, "each cell")
    return dims[len(axes) :]


def _unfit(name: str, row: str) -> ConfigError:
    return ConfigError(f"{name} does not fit into a table with a row for {row}", possible="a table of its own, or --nc")


def _headers(result: Result, name: str, inner: str) -> list[str]:
    """Return the names of the components of a variable."""
    extra = result.stored.dims[name][len(result.sweep.grid.axes) + bool(inner) :]
    return [f"{name}_{label}" for label in result[extra[0]]] if extra else [name]


def _columns(result: Result, name: str, block: Part, rows: int) -> list[np.ndarray]:
    """Return the values, (rows,), of each component of a variable in a block."""
    values = result.part(name, block).reshape(rows, -1)
    meanings = result.stored.attributes[name].get("flag_meanings")
    return list((values if meanings is None else np.array(meanings.split())[values]).T)


def _texts(values: np.ndarray) -> list[str]:
    """Return values as text that reads back to the same bits; NaN as nothing."""
    if values.dtype.kind != "f":
        return [str(value) for value in values.tolist()]
    return ["" if math.isnan(value) else repr(value) for value in values.tolist()]
