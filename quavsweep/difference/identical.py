"""How much of two results is the same: bytes, content, data; and in which variables they differ, in how many cells."""

from __future__ import annotations

import filecmp
from pathlib import Path

import numpy as np

from quavsweep.difference.common import Common
from quavsweep.result import Result
from quavsweep.store import RunFolder
from quavsweep.store.netcdf import DIGEST


def differing_variables(common: Common) -> dict[str, int]:
    """Return the variables of both whose bits differ, and in how many of the cells or points in common.

    One whose shape differs beyond the axes, such as that of more exponents, differs in all of them.
    """
    counts = {name: _differing(common, name) for name in common.a.variables if name in common.b.variables}
    return {name: count for name, count in counts.items() if count}


def _differing(common: Common, name: str) -> int:
    """Return in how many cells, or points, a variable differs."""
    dims = [result.stored.dims[name] for result in (common.a, common.b)]
    axes = tuple(axis for axis in common.indices if axis in dims[0])
    others = [tuple(dim for dim in of if dim not in common.indices) for of in dims]
    if set(dims[0]) != set(dims[1]) or others[0] != others[1]:
        return common.grid.size
    count = 0
    for box in common.boxes(axes):
        one, other = common.read(name, box)
        if one.shape != other.shape or one.dtype != other.dtype:
            count += len(one)
        else:
            count += int(_unlike(one, other).any(axis=1).sum())
    return count


def _unlike(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether bits differ, (n, m) bool."""
    if one.dtype.kind == "f":
        one, other = (np.ascontiguousarray(x).view(f"u{x.dtype.itemsize}") for x in (one, other))
    return np.asarray(one != other).reshape(len(one), -1)


def same_data(common: Common, differing: dict[str, int]) -> bool:
    """Whether both have the same cells and variables, and the same bits in all of them."""
    a, b = common.a, common.b
    if differing or not common.whole or set(a.stored.dims) != set(b.stored.dims):
        return False
    return all(np.array_equal(a[name], b[name]) for name in a.stored.dims if name not in a.variables)


def same_content(a: Result, b: Result) -> bool:
    """Whether all data and attributes of two files are the same, by the digests that they hold."""
    one, other = (result.stored.file_attributes.get(DIGEST) for result in (a, b))
    return one is not None and bool(one == other)


def same_bytes(a: Path, b: Path) -> bool:
    """Whether both are result files, or folders with one, of the same bytes."""
    one, other = (RunFolder(path).result if path.is_dir() else path for path in (a, b))
    return one.is_file() and other.is_file() and filecmp.cmp(one, other, shallow=False)
