"""Result files: netCDF-4 compatible HDF5, written block by block, with a digest over all data and attributes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from quavsweep.errors import DamageError, DiskError
from quavsweep.grid import Grid
from quavsweep.measures import Variable
from quavsweep.store.publish import is_sealed, publish_hdf5

BLOCK_CELLS = 8192  # cells that are classified, compressed and read at once, at most
BLOCK_BYTES = 2**26  # of their evidence, about
_STRUCTURE = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "_Netcdf4Dimid", "_NCProperties")
_DIGEST = "content_sha256"
REBUILD = "run the sweep again to rebuild it"


@dataclass(frozen=True)
class Coordinate:
    """A dimension's coordinate: name, values, and attributes."""

    name: str
    values: np.ndarray
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Stored:
    """A result file in memory: arrays, dimensions and attributes by variable, and the attributes of the file."""

    data: dict[str, np.ndarray]
    dims: dict[str, tuple[str, ...]]
    attributes: dict[str, dict[str, Any]]
    file_attributes: dict[str, Any]


def block_cells(cell_bytes: int) -> int:
    """Return how many cells are classified, compressed and read at once, from the size of a cell's evidence."""
    return max(1, min(BLOCK_CELLS, BLOCK_BYTES // cell_bytes))


def write_result(
    path: Path,
    grid: Grid,
    coordinates: Iterable[Coordinate],
    variables: Mapping[Variable, Mapping[str, Any]],
    blocks: Iterable[tuple[tuple[slice, ...], Mapping[str, np.ndarray]]],
    attributes: Mapping[str, str],
    cells: int,
) -> None:
    """Publish a result file from a stream of blocks.

    The file's bytes depend on nothing but the arguments.

    Parameters
    ----------
    grid : Grid
        The first dimensions of every variable.
    coordinates : iterable of Coordinate
        One per dimension, the grid's axes first.
    variables : mapping from Variable to attributes
        What the blocks hold.
    blocks : iterable of (slices, values)
        In the order of `grid.blocks(cells)`; values have the shape (cells, ...).
    attributes : mapping
        Of the file.
    cells : int
        Cells per block, and per chunk of the file.

    Raises
    ------
    DiskError
        If it cannot be written.
    """

    def write(file: h5py.File) -> None:
        extents = {}
        for coordinate in coordinates:
            text = coordinate.values.dtype.kind == "O"
            kind = h5py.string_dtype() if text else coordinate.values.dtype
            scale = file.create_dataset(coordinate.name, data=coordinate.values, dtype=kind)
            scale.make_scale(coordinate.name)
            _set_attributes(scale, coordinate.attributes)
            extents[coordinate.name] = len(coordinate.values)
        digests = {}
        for variable, extra in variables.items():
            _create(file, grid, variable, extents, extra, cells)
            digests[variable.name] = hashlib.sha256()
        for block, values in blocks:
            for variable in variables:
                array = np.ascontiguousarray(values[variable.name], dtype=variable.dtype)
                shape = tuple(s.stop - s.start for s in block) + array.shape[1:]
                file[variable.name][block] = array.reshape(shape)
                digests[variable.name].update(array.data)
        _set_attributes(file, attributes)
        _set_attributes(file, {_DIGEST: _content_digest(file, {n: d.hexdigest() for n, d in digests.items()})})

    publish_hdf5(lambda sha256, size: path, write, in_memory=False)


def write_copy(stored: Stored, path: Path) -> None:
    """Publish a file of variables that are in memory, netCDF-4 compatible.

    Raises
    ------
    DiskError
        If it cannot be written.
    """

    def write(file: h5py.File) -> None:
        scales = [name for name, dims in stored.dims.items() if dims == (name,)]
        for name in sorted(stored.data, key=lambda name: name not in scales):
            values, dims = stored.data[name], stored.dims[name]
            kind = h5py.string_dtype() if values.dtype.kind == "O" else values.dtype
            options = {"compression": "gzip", "shuffle": True} if values.ndim else {}
            dataset = file.create_dataset(name, data=values, dtype=kind, **options)
            if name in scales:
                dataset.make_scale(name)
            else:
                for i, dim in enumerate(dims):
                    dataset.dims[i].attach_scale(file[dim])
            _set_attributes(dataset, stored.attributes[name])
        kept = {key: value for key, value in stored.file_attributes.items() if key != _DIGEST}
        _set_attributes(file, kept)

    publish_hdf5(lambda sha256, size: path, write, in_memory=False)


def _create(
    file: h5py.File,
    grid: Grid,
    variable: Variable,
    extents: Mapping[str, int],
    attributes: Mapping[str, Any],
    cells: int,
) -> None:
    dims = (*(axis.name for axis in grid.axes), *variable.dims)
    shape = grid.shape + tuple(extents[dim] for dim in variable.dims)
    options: dict[str, Any] = {}
    if grid.axes:
        chunks = grid.block_shape(cells) + shape[len(grid.shape) :]
        options = {"chunks": chunks, "shuffle": True, "compression": "gzip", "compression_opts": 4, "fletcher32": True}
    dataset = file.create_dataset(variable.name, shape, variable.dtype, **options)
    for i, dim in enumerate(dims):
        dataset.dims[i].attach_scale(file[dim])
    _set_attributes(dataset, attributes)


def _set_attributes(target: h5py.HLObject, attributes: Mapping[str, Any]) -> None:
    for key, value in attributes.items():
        target.attrs[key] = np.bytes_(value.encode("utf-8")) if isinstance(value, str) else value


def _attributes(target: h5py.HLObject) -> dict[str, Any]:
    """Return an object's attributes, texts as str, without those that HDF5 and netCDF keep for themselves."""
    found = {}
    for key in sorted(target.attrs):
        if key not in _STRUCTURE:
            value = target.attrs[key]
            found[key] = value.decode("utf-8") if isinstance(value, bytes) else value
    return found


def _content_digest(file: h5py.File, digests: dict[str, str]) -> str:
    """Return the SHA-256 over names, types, shapes, dimensions, attributes and the digests of the data."""
    content: list[Any] = []
    for name in sorted(file):
        dataset = file[name]
        data = digests.get(name) or hashlib.sha256(_bytes(_values(dataset))).hexdigest()
        listed = {key: np.asarray(value).tolist() for key, value in _attributes(dataset).items()}
        content.append([name, dataset.dtype.str, dataset.shape, _dims(file, name), listed, data])
    top = {key: np.asarray(value).tolist() for key, value in _attributes(file).items() if key != _DIGEST}
    return hashlib.sha256(json.dumps([content, top], sort_keys=True).encode()).hexdigest()


def _values(dataset: h5py.Dataset) -> np.ndarray:
    """Return a dataset in memory, texts as str."""
    return np.asarray(dataset.asstr()[()] if dataset.dtype.kind == "O" else dataset[()])


def _bytes(values: np.ndarray) -> bytes:
    if values.dtype.kind == "O":
        return json.dumps(list(values.ravel())).encode()
    return values.tobytes()


def _dims(file: h5py.File, name: str) -> tuple[str, ...]:
    dataset = file[name]
    if dataset.is_scale:
        return (name,)
    return tuple(dim[0].name.lstrip("/") for dim in dataset.dims)


def read_result(path: Path, names: Container[str] | None = None) -> Stored:
    """Return a result file's content, or only the variables of these names, after the file has been verified.

    Raises
    ------
    DamageError
        If its content is not what was written.
    DiskError
        If it may not be read.
    """
    try:
        if not is_sealed(path):
            raise DamageError("its bytes are not those that were written", str(path), REBUILD)
        with h5py.File(path, "r") as file:
            wanted = [name for name in sorted(file) if names is None or name in names]
            stored = Stored(
                data={name: _values(file[name]) for name in wanted},
                dims={name: _dims(file, name) for name in wanted},
                attributes={name: _attributes(file[name]) for name in wanted},
                file_attributes=_attributes(file),
            )
            digests = {name: hashlib.sha256(_bytes(values)).hexdigest() for name, values in stored.data.items()}
            # The seal covers every byte; the digest of the content is checked where all of it is read anyway.
            good = names is not None or stored.file_attributes.get(_DIGEST) == _content_digest(file, digests)
    except FileNotFoundError:
        raise
    except PermissionError as error:
        raise DiskError(f"cannot be read: {error.strerror}", str(path)) from error
    except (OSError, KeyError, ValueError, RuntimeError, TypeError, AttributeError, IndexError) as error:
        raise DamageError("cannot be read as a result file", str(path), REBUILD) from error
    if not good:
        raise DamageError("its content is not what was written", str(path), REBUILD)
    return stored
