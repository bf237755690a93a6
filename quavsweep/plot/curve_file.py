"""Curves from CSV files whose header names the axes."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from quavsweep.errors import ConfigError


def read_curve(path: Path, x: str, y: str) -> np.ndarray:
    """Return the points of a curve, (n, 2), from the columns of a file that are called x and y.

    Raises
    ------
    ConfigError
        If the file cannot be read, has no such columns, or a row without two finite numbers, or fewer than two rows.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            points = list(_points(path, csv.reader(file, strict=True, skipinitialspace=True), (x, y)))
    except OSError as error:
        raise ConfigError(f"cannot be read: {error.strerror or error}", str(path)) from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"is no CSV file: {error}", str(path)) from error
    if len(points) < 2:
        raise ConfigError(f"a curve needs at least two points, here are {len(points)}", str(path))
    return np.array(points)


def _points(path: Path, rows: Iterator[list[str]], names: tuple[str, str]) -> Iterator[tuple[float, ...]]:
    """Yield the points of the rows behind the header."""
    header = [name.strip() for name in next(rows, [])]
    missing = [name for name in names if name not in header]
    if missing:
        possible = f"the header is to name the axes, {names[0]} and {names[1]}"
        raise ConfigError(f"has no column {missing[0]}", f"{path}:1", possible)
    columns = [header.index(name) for name in names]
    for row in rows:
        if row:
            where = f"{path}:{rows.line_num}"  # type: ignore[attr-defined]
            yield tuple(_number(row, column, header[column], where) for column in columns)


def _number(row: list[str], column: int, name: str, where: str) -> float:
    """Return a number of a row."""
    text = row[column].strip() if column < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError(f"{name} is {repr(text) if text else 'missing'}", where, "it should be a finite number")
    return value
