"""What may be in a file from elsewhere: flat datasets of numbers and texts, stored in the file itself, as results are.

Everything else that HDF5 can do is refused before any of it is read: other files, links, foreign filters, references.
"""

from __future__ import annotations

import math
import re

import h5py
from h5py import h5a, h5d, h5o, h5s, h5t, h5z

from quavsweep.store.wire import LARGEST_CONTENT

MOST_VARIABLES = 1000
MOST_ATTRIBUTES = 100
LARGEST_ATTRIBUTE = 2**22  # bytes
LARGEST_CHUNK = 2**27  # bytes
LARGEST_RANK = 16
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.]{0,99}")
SCALES = ("DIMENSION_LIST", "REFERENCE_LIST")  # by which HDF5 knows dimensions
_LAYOUTS = (h5d.COMPACT, h5d.CONTIGUOUS, h5d.CHUNKED)
_FILTERS = (h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32)
_SIZES = (1, 2, 4, 8)


class RefusedContent(ValueError):  # noqa: N818  what it says of a file is no error of this program
    """What is in the file that may not be there."""


def _hold(condition: bool, otherwise: str) -> None:
    if not condition:
        raise RefusedContent(otherwise)


def screen(file: h5py.File) -> None:
    """Refuse a file that is not made as results and shards are.

    Raises
    ------
    RefusedContent
        With what is wrong.
    """
    root = file.id
    _hold(len(root) <= MOST_VARIABLES, "too many variables")
    names = [name.decode("utf-8", "replace") for name in root]
    for name in names:
        _hold(NAME.fullmatch(name) is not None, "a variable with an odd name")
        _hold(root.links.get_info(name.encode()).type == h5py.h5l.TYPE_HARD, "a link that leads elsewhere")
    _screen_attributes(h5o.open(root, b"/"), 0)
    total = 0
    for name in names:
        _hold(h5o.get_info(root, name.encode()).type == h5o.TYPE_DATASET, "a group or a type")
        total += _screen_dataset(h5d.open(root, name.encode()))
        _hold(total <= LARGEST_CONTENT, f"more than {LARGEST_CONTENT >> 20} MiB of numbers")


def _screen_dataset(dataset: h5d.DatasetID) -> int:
    """Refuse a dataset that is not stored plainly in the file; return its bytes."""
    space, creation = dataset.get_space(), dataset.get_create_plist()
    _hold(creation.get_external_count() == 0, "data stored in another file")
    _hold(creation.get_layout() in _LAYOUTS, "data that are views of other data")
    used = [creation.get_filter(i)[0] for i in range(creation.get_nfilters())]
    _hold(len(used) <= len(_FILTERS) and set(used) <= set(_FILTERS), "a foreign filter")
    _hold(space.get_simple_extent_type() in (h5s.SIMPLE, h5s.SCALAR), "a dataset without extent")
    shape = space.get_simple_extent_dims()
    _hold(len(shape) <= LARGEST_RANK and space.get_simple_extent_dims(True) == shape, "an odd shape")
    size = _screen_type(dataset.get_type())
    if creation.get_layout() == h5d.CHUNKED:
        _hold(math.prod(creation.get_chunk()) * size <= LARGEST_CHUNK, "a chunk that is too large")
    _screen_attributes(dataset, len(shape))
    return int(math.prod(shape)) * size


def _screen_type(kind: h5t.TypeID) -> int:
    """Refuse what are neither plain numbers nor texts; return the bytes of one."""
    if kind.get_class() == h5t.STRING:
        return int(kind.get_size())
    _hold(kind.get_class() in (h5t.INTEGER, h5t.FLOAT), "data that are neither numbers nor texts")
    _hold(kind.get_size() in _SIZES and kind.dtype.itemsize == kind.get_size(), "numbers of an odd type")
    return int(kind.get_size())


def _screen_attributes(target: h5py.h5g.GroupID | h5d.DatasetID, rank: int) -> None:
    """Refuse attributes that are large, or neither numbers nor texts."""
    count = h5a.get_num_attrs(target)
    _hold(count <= MOST_ATTRIBUTES, "too many attributes")
    for index in range(count):
        attribute = h5a.open(target, index=index)
        shape, kind = attribute.shape, attribute.get_type()
        if attribute.name.decode("utf-8", "replace") in SCALES:
            _hold(len(shape) == 1 and shape[0] <= MOST_VARIABLES, "an odd list of dimensions")
            if attribute.name == b"DIMENSION_LIST":
                plain = kind.get_class() == h5t.VLEN and kind.get_super().equal(h5t.STD_REF_OBJ)
                _hold(plain and shape[0] == rank, "an odd list of dimensions")
            continue
        _hold(len(shape) <= 1, "an attribute with an odd shape")
        size = kind.get_size() if kind.get_class() == h5t.STRING else _screen_type(kind)
        _hold(math.prod(shape) * size <= LARGEST_ATTRIBUTE, "an attribute that is too large")
