"""A few of the cells of a result: evenly spaced ones along its axes, read when they are asked for and not before."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from quavsweep.store.stored import Part, Stored, Variables


def thin(whole: Stored, chosen: Mapping[str, range]) -> Stored:
    """Return what is stored at some values of dimensions, by their indices."""

    def read(name: str, part: Part) -> np.ndarray:
        dims = whole.dims[name]
        asked = (*part, *(slice(None) for _ in dims[len(part) :]))
        where = (_among(chosen[dim], own) if dim in chosen else own for dim, own in zip(dims, asked, strict=True))
        return np.asarray(whole.part(name, tuple(where)))

    return Stored(Variables(tuple(whole.dims), read), whole.dims, whole.attributes, whole.file_attributes)


def _among(chosen: range, part: slice | int) -> slice | int:
    """Return which part of the whole is a part of the chosen indices."""
    if isinstance(part, slice):
        left = chosen[part]
        return slice(left.start, left.stop, left.step)
    return chosen[part]
