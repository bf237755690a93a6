"""What a file from elsewhere says must be what a result of its own config has; only numbers are taken from it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.classify import result_variables
from quavsweep.codes import Code
from quavsweep.config import Sweep
from quavsweep.errors import ConfigError, DamageError
from quavsweep.grid import Grid
from quavsweep.measures import Variable
from quavsweep.reduction import ATTRACTOR, passed_variables, point_variables
from quavsweep.store.doubt import AGAIN, Misfit, doubted, sweep_of
from quavsweep.store.foreign import TRUST, ForeignFile
from quavsweep.store.netcdf import DIGEST, Coordinate
from quavsweep.store.outcome import DESCRIPTION, coordinates_of, variable_attributes
from quavsweep.store.stored import Part, Stored, Variables
from quavsweep.store.wire import LARGEST_CONTENT

MOST_CELLS = 2 * 10**6
LONGEST_AXIS = 10**5  # a line of a million points takes 3.4 GB to draw
LARGEST_EVIDENCE = 2**32  # bytes
LONGEST = 1000  # characters of a text
_IDS = ("evidence_id", "toolchain_id", "result_id", DIGEST)
_TEXTS = ("Conventions", "title", "source", "model")


def fitted(foreign: ForeignFile, path: Path) -> Stored:
    """Return the content of a file from elsewhere, whose shapes, types, coordinates and codes fit its config.

    Meanings and units are this engine's own, and texts of the file that are not needed are left out.

    Raises
    ------
    ConfigError, DamageError
        If anything does not.
    """
    sweep = sweep_of(foreign.attributes, path)
    with doubted(path):
        _check_cells(sweep, path)
        attributes = _file_attributes(foreign.attributes)
        dims, told = _fit(foreign, sweep)
        cells, points = _variables(sweep)
        codes = {name: variable.codes for name, variable in {**cells, **points}.items() if variable.codes}
        names = tuple(sorted(dims))
        data = Variables(names, lambda name, part: _read(foreign, name, part, codes.get(name, ())))
    return Stored(data, {n: dims[n] for n in names}, {n: told[n] for n in names}, attributes, foreign=True)


def _fit(foreign: ForeignFile, sweep: Sweep) -> tuple[dict[str, tuple[str, ...]], dict[str, dict[str, Any]]]:
    """Return the dimensions and attributes of all variables, which are known to fit then."""
    cells, points = _variables(sweep)
    coordinates = {coordinate.name: coordinate for coordinate in coordinates_of(sweep)}
    _check_names(foreign, sweep, {*cells, *points}, set(coordinates))
    dims: dict[str, tuple[str, ...]] = {}
    told: dict[str, Mapping[str, Any]] = {}
    for name, coordinate in coordinates.items():
        if name in foreign.variables:
            _check_coordinate(foreign, coordinate)
            dims[name], told[name] = (coordinate.dim or name,), coordinate.attributes
    for grid, variables, of_points in ((sweep.grid, cells, False), (sweep.points, points, True)):
        for name, variable in variables.items():
            if name in foreign.variables:
                dims[name] = _check_variable(foreign, grid, variable, coordinates)
                told[name] = variable_attributes(sweep, variable, of_points)
    return dims, {name: dict(sorted(attributes.items())) for name, attributes in told.items()}


def _variables(sweep: Sweep) -> tuple[dict[str, Variable], dict[str, Variable]]:
    """Return what a result of the sweep may have of its cells and of its parameter points, by name."""
    cells = (*passed_variables(sweep), *result_variables(sweep), *((ATTRACTOR,) if sweep.start_axes else ()))
    return {v.name: v for v in cells}, {v.name: v for v in point_variables(sweep)}


def _hold(condition: bool, otherwise: str) -> None:
    if not condition:
        raise Misfit(otherwise)


def _check_names(foreign: ForeignFile, sweep: Sweep, variables: set[str], coordinates: set[str]) -> None:
    present = set(foreign.variables)
    _hold(present <= variables | coordinates, "a variable that no such result has")
    needed = {"status", "region", *(name for axis in sweep.grid.axes for name in (axis.name, *axis.quantities))}
    _hold(needed <= present, "a variable is missing")


def _check_variable(
    foreign: ForeignFile, grid: Grid, variable: Variable, coordinates: Mapping[str, Coordinate]
) -> tuple[str, ...]:
    """Return the dimensions of a variable whose shape and type fit."""
    content = foreign.variables[variable.name]
    shape = (*grid.shape, *(len(coordinates[dim].values) for dim in variable.dims))
    _hold(content.shape == shape, "another shape")
    _hold(bool(content.dtype) and np.dtype(content.dtype) == np.dtype(variable.dtype), "another type")
    dims = (*(axis.name for axis in grid.axes), *variable.dims)
    _hold(content.dims == dims and set(dims) <= set(foreign.variables), "other dimensions")
    return dims


def _check_coordinate(foreign: ForeignFile, coordinate: Coordinate) -> None:
    """Refuse other values than those of the config."""
    content, expected = foreign.variables[coordinate.name], coordinate.values
    _hold(content.shape == expected.shape and bool(content.dtype) == (expected.dtype.kind != "O"), "another coordinate")
    values = foreign.read(coordinate.name)
    same = np.allclose(values, expected, rtol=1e-9, atol=0) if content.dtype else list(values) == list(expected)
    _hold(same, "another coordinate")


def _read(foreign: ForeignFile, name: str, part: Part, codes: tuple[Code, ...]) -> np.ndarray:
    """Return a part of a variable; a code that does not exist is damage."""
    values = foreign.read(name, part)
    if codes and not np.isin(values, [code.number for code in codes]).all():
        raise DamageError(f"holds a {name} that does not exist", foreign.where, AGAIN)
    return values


def _file_attributes(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return those attributes of a file that a reader needs, after a check that they can be printed."""
    kept = {key: given[key] for key in (*_IDS, *_TEXTS, "config", DESCRIPTION) if key in given}
    _hold(set(_IDS) <= set(kept), "an identity is missing")
    for key, value in kept.items():
        _hold(isinstance(value, str), "a text is none")
        _hold(key not in _IDS or re.fullmatch("[0-9a-f]{32,64}", value) is not None, "an odd identity")
        _hold(key not in _TEXTS or (len(value) <= LONGEST and value.isprintable()), "an odd text")
    return kept


def check_evidence(sweep: Sweep, where: Path) -> None:
    """Refuse to make a result of the evidence in a folder from elsewhere where that is too large for a look.

    Raises
    ------
    ConfigError
        With what is possible.
    """
    lengths = {coordinate.name: len(coordinate.values) for coordinate in coordinates_of(sweep)}
    cells, points = _variables(sweep)
    size = sum(
        np.dtype(v.dtype).itemsize * grid.size * math.prod(lengths[dim] for dim in v.dims)
        for grid, variables in ((sweep.grid, cells), (sweep.points, points))
        for v in variables.values()
    )
    if size > LARGEST_CONTENT or sweep.grid.size * sweep.cell_bytes > LARGEST_EVIDENCE:
        what = f"has {sweep.grid.size:,} cells of {sweep.cell_bytes:,} bytes, too many for a run from elsewhere"
        raise ConfigError(what, str(where), TRUST)
    _check_cells(sweep, where)


def _check_cells(sweep: Sweep, where: Path) -> None:
    """Refuse a grid that would take long or much memory to draw."""
    if sweep.grid.size > MOST_CELLS or max(sweep.grid.shape, default=1) > LONGEST_AXIS:
        what = f"has {' x '.join(f'{n:,}' for n in sweep.grid.shape)} cells, too many for a result from elsewhere"
        possible = f"at most {MOST_CELLS:,}, and {LONGEST_AXIS:,} along an axis; {TRUST}"
        raise ConfigError(what, str(where), possible)
