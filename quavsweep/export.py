"""A result's variables for other programs: a table of text, or a netCDF file of its own."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import numpy as np

from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest
from quavsweep.result import Result
from quavsweep.store import Part, block_cells, write_copy


def write_csv(result: Result, names: Sequence[str], stream: IO[str]) -> None:
    """Write variables as a table: a row per cell, axes first; a variable with components has a column for each.

    Codes are written as their names, and nothing where there is no number.

    Raises
    ------
    ConfigError
        If a variable does not exist or has more than one dimension beyond the axes.
    """
    table = csv.writer(stream, lineterminator="\n")
    headers = [header for name in names for header in _headers(result, name)]
    grid = result.sweep.grid
    table.writerow([*grid.coordinates(0, 1), *headers])
    for block in grid.blocks(block_cells(result.sweep.cell_bytes)):
        start, stop = grid.span(block)
        axes = [_texts(values) for values in grid.coordinates(start, stop).values()]
        columns = [_texts(column) for name in names for column in _columns(result, name, block, stop - start)]
        table.writerows(zip(*axes, *columns, strict=True))


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
    kept = {*names, *(dim for name in names for dim in stored.dims[name])}
    write_copy(stored, kept, path)


def _check(result: Result, name: str) -> None:
    if name not in result:
        what = f"there is no variable {name}{nearest(name, result.variables)}"
        raise ConfigError(what, possible=f"there are {', '.join(result.variables)}")


def _headers(result: Result, name: str) -> list[str]:
    """Return the names of the components of a variable."""
    _check(result, name)
    extra = result.stored.dims[name][len(result.sweep.grid.axes) :]
    if len(extra) > 1 or name in result.stored.dims[name]:
        raise ConfigError(f"{name} is no table of one row per cell", possible="write it with --nc")
    return [f"{name}_{label}" for label in result[extra[0]]] if extra else [name]


def _columns(result: Result, name: str, block: Part, cells: int) -> list[np.ndarray]:
    """Return the values, (cells,), of each component of a variable in a block."""
    values = result.part(name, block).reshape(cells, -1)
    meanings = result.stored.attributes[name].get("flag_meanings")
    return list((values if meanings is None else np.array(meanings.split())[values]).T)


def _texts(values: np.ndarray) -> list[str]:
    """Return values as text that reads back to the same bits; NaN as nothing."""
    if values.dtype.kind != "f":
        return [str(value) for value in values.tolist()]
    return ["" if math.isnan(value) else repr(value) for value in values.tolist()]
