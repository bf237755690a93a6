"""A result's variables for other programs: a table of text, or a netCDF file of its own."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

import numpy as np

from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest
from quavsweep.result import Result
from quavsweep.store import Stored, write_copy


def write_csv(result: Result, names: Sequence[str], stream: IO[str]) -> None:
    """Write variables as a table: a row per cell, axes first; a variable with components has a column for each.

    Codes are written as their names, and nothing where there is no number.

    Raises
    ------
    ConfigError
        If a variable does not exist or has more than one dimension beyond the axes.
    """
    table = csv.writer(stream, lineterminator="\n")
    columns = [column for name in names for column in _columns(result, name)]
    table.writerow([*(axis.name for axis in result.sweep.grid.axes), *(name for name, _ in columns)])
    grid = result.sweep.grid
    for block in grid.blocks(8192):
        start, stop = grid.span(block)
        axes = [_texts(values) for values in grid.coordinates(start, stop).values()]
        table.writerows(zip(*axes, *(_texts(values[start:stop]) for _, values in columns), strict=True))


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
    write_copy(
        Stored(
            {name: stored.data[name] for name in kept},
            {name: stored.dims[name] for name in kept},
            {name: stored.attributes[name] for name in kept},
            stored.file_attributes,
        ),
        path,
    )


def _check(result: Result, name: str) -> None:
    if name not in result:
        what = f"there is no variable {name}{nearest(name, result.variables)}"
        raise ConfigError(what, possible=f"there are {', '.join(result.variables)}")


def _columns(result: Result, name: str) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the name and the values, (cells,), of each component of a variable."""
    _check(result, name)
    size, dims = result.sweep.grid.size, result.stored.dims[name]
    extra = dims[len(result.sweep.grid.axes) :]
    values = result[name].reshape(size, -1)
    if len(extra) > 1 or name in dims:
        raise ConfigError(f"{name} is no table of one row per cell", possible="write it with --nc")
    meanings = result.stored.attributes[name].get("flag_meanings")
    if meanings is not None:
        values = np.array(meanings.split())[values]
    labels = [f"_{label}" for label in result[extra[0]]] if extra else [""]
    for column, label in enumerate(labels):
        yield f"{name}{label}", values[:, column]


def _texts(values: np.ndarray) -> list[str]:
    """Return values as text that reads back to the same bits; NaN as nothing."""
    if values.dtype.kind != "f":
        return [str(value) for value in values.tolist()]
    return ["" if math.isnan(value) else repr(value) for value in values.tolist()]
