"""Result files: netCDF-4 compatible HDF5, written block by block, with a digest over all data and attributes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from quavsweep.grid import Grid
from quavsweep.measures import Variable
from quavsweep.store.publish import give_way, publish_hdf5
from quavsweep.store.stored import Part, Stored

BLOCK_CELLS = 8192  # cells that are classified, compressed and read at once, at most
BLOCK_BYTES = 2**26  # of their evidence, about
COPIED = 2**18  # numbers of a variable that are copied at once
_STRUCTURE = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "_Netcdf4Dimid", "_NCProperties")
DIGEST = "content_sha256"


@dataclass(frozen=True)
class Coordinate:
    """A coordinate: name, values, attributes, and the dimension that it belongs to, if not the one of its name."""

    name: str
    values: np.ndarray
    attributes: Mapping[str, str] = field(default_factory=dict)
    dim: str = ""

    @property
    def is_own(self) -> bool:
        """Whether it makes the dimension."""
        return self.dim in ("", self.name)


@dataclass(frozen=True)
class Reduction:
    """What is made of cells once they are written, some parameter points at a time.

    Parameters
    ----------
    grid : Grid
        Of the points: some of the axes of the cells.
    points, cells : mapping from Variable to attributes
        What it gives for each point, and for each cell.
    reads : tuple of str
        The variables of cells that it needs.
    reduce : callable
        From these, (points, starts, ...) each, to what it gives, by name.
    """

    grid: Grid
    points: Mapping[Variable, Mapping[str, Any]]
    cells: Mapping[Variable, Mapping[str, Any]]
    reads: tuple[str, ...]
    reduce: Callable[[Mapping[str, np.ndarray]], Mapping[str, np.ndarray]]


def block_cells(cell_bytes: int) -> int:
    """Return how many cells are classified, compressed and read at once, from the size of a cell's evidence."""
    return max(1, min(BLOCK_CELLS, BLOCK_BYTES // cell_bytes))


def write_result(
    path: Path,
    grid: Grid,
    coordinates: Iterable[Coordinate],
    variables: Mapping[Variable, Mapping[str, Any]],
    blocks: Iterable[tuple[tuple[slice, ...], Mapping[str, np.ndarray]]],
    attributes: Mapping[str, Any],
    cells: int,
    reduction: Reduction | None = None,
) -> None:
    """Publish a result file from a stream of blocks.

    The file's bytes depend on nothing but the arguments.

    Parameters
    ----------
    grid : Grid
        The first dimensions of every variable.
    coordinates : iterable of Coordinate
        One per dimension, the grid's axes first, each before others along it.
    variables : mapping from Variable to attributes
        What the blocks hold.
    blocks : iterable of (slices, values)
        In the order of `grid.blocks(cells)`; values have the shape (cells, ...).
    attributes : mapping
        Of the file.
    cells : int
        Cells per block, and per chunk of the file.
    reduction : Reduction, optional
        What is added when all blocks are written.

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
            dataset = file.create_dataset(coordinate.name, data=coordinate.values, dtype=kind)
            if coordinate.is_own:
                dataset.make_scale(coordinate.name)
                extents[coordinate.name] = len(coordinate.values)
            else:
                dataset.dims[0].attach_scale(file[coordinate.dim])
            _set_attributes(dataset, coordinate.attributes)
        digests = {}
        for variable, extra in variables.items():
            _create(file, grid, variable, extents, extra, grid.block_shape(cells))
            digests[variable.name] = hashlib.sha256()
        for block, values in blocks:
            give_way()
            for variable in variables:
                array = np.ascontiguousarray(values[variable.name], dtype=variable.dtype)
                shape = tuple(s.stop - s.start for s in block) + array.shape[1:]
                file[variable.name][block] = array.reshape(shape)
                digests[variable.name].update(array.data)
        if reduction is not None:
            _reduce(file, grid, reduction, extents, cells)
        _set_attributes(file, attributes)
        _set_attributes(file, {DIGEST: content_digest(file, {n: d.hexdigest() for n, d in digests.items()})})

    publish_hdf5(lambda sha256, size: path, write, in_memory=False)


def write_copy(stored: Stored, names: Iterable[str], path: Path) -> None:
    """Publish a file of some variables, netCDF-4 compatible, with a block of one of them in memory at a time.

    Raises
    ------
    DiskError
        If it cannot be written.
    """

    def write(file: h5py.File) -> None:
        for name in sorted(names, key=lambda name: (stored.dims[name] != (name,), name)):  # coordinates first
            dims, grid = stored.dims[name], stored.grid(name)
            first = stored.part(name, (0,) * len(dims))
            kind = h5py.string_dtype() if first.dtype.kind in "OU" else first.dtype
            options = {"compression": "gzip", "shuffle": True, "chunks": grid.block_shape(COPIED)} if dims else {}
            dataset = file.create_dataset(name, grid.shape, kind, **options)
            for part in grid.blocks(COPIED):
                give_way()
                dataset[part] = stored.part(name, part)
            if dims == (name,):
                dataset.make_scale(name)
            else:
                for i, dim in enumerate(dims):
                    dataset.dims[i].attach_scale(file[dim])
            _set_attributes(dataset, stored.attributes[name])
        kept = {key: value for key, value in stored.file_attributes.items() if key != DIGEST}
        _set_attributes(file, kept)

    publish_hdf5(lambda sha256, size: path, write, in_memory=False)


def _reduce(file: h5py.File, grid: Grid, reduction: Reduction, extents: Mapping[str, int], cells: int) -> None:
    """Add variables of points and cells, reading the cells of a few points at a time."""
    inner = reduction.grid
    starts = grid.size // inner.size
    at_once = max(1, cells // starts)
    lengths = dict(zip((axis.name for axis in inner.axes), inner.block_shape(at_once), strict=True))
    chunk = tuple(lengths.get(axis.name, len(axis)) for axis in grid.axes)  # whole chunks are written once
    for variable, extra in reduction.points.items():
        _create(file, inner, variable, extents, extra, inner.block_shape(cells))
    for variable, extra in reduction.cells.items():
        _create(file, grid, variable, extents, extra, chunk)
    to_front = [i for i, axis in enumerate(grid.axes) if axis.name in lengths]
    order = [*to_front, *(i for i in range(len(grid.axes)) if i not in to_front)]
    for block in inner.blocks(at_once):
        give_way()
        chosen = dict(zip(lengths, block, strict=True))
        where = tuple(chosen.get(axis.name, slice(0, len(axis))) for axis in grid.axes)
        shape = tuple(s.stop - s.start for s in where)

        def of_points(name: str, where: tuple[slice, ...] = where) -> np.ndarray:
            array = read_values(file[name], where)
            array = array.transpose(*order, *range(len(order), array.ndim))
            return array.reshape(-1, starts, *array.shape[len(order) :])

        found = reduction.reduce({name: of_points(name) for name in reduction.reads})
        for variable in reduction.points:
            array = np.asarray(found[variable.name], dtype=variable.dtype)
            file[variable.name][block] = array.reshape((*(s.stop - s.start for s in block), *array.shape[1:]))
        for variable in reduction.cells:
            array = np.asarray(found[variable.name], dtype=variable.dtype)
            file[variable.name][where] = array.reshape([shape[i] for i in order]).transpose(np.argsort(order))


def _create(
    file: h5py.File,
    grid: Grid,
    variable: Variable,
    extents: Mapping[str, int],
    attributes: Mapping[str, Any],
    chunk: tuple[int, ...],
) -> None:
    dims = (*(axis.name for axis in grid.axes), *variable.dims)
    shape = grid.shape + tuple(extents[dim] for dim in variable.dims)
    options: dict[str, Any] = {}
    if grid.axes:
        chunks = chunk + shape[len(grid.shape) :]
        options = {"chunks": chunks, "shuffle": True, "compression": "gzip", "compression_opts": 4, "fletcher32": True}
    dataset = file.create_dataset(variable.name, shape, variable.dtype, **options)
    for i, dim in enumerate(dims):
        dataset.dims[i].attach_scale(file[dim])
    _set_attributes(dataset, attributes)


def _set_attributes(target: h5py.HLObject, attributes: Mapping[str, Any]) -> None:
    for key, value in attributes.items():
        target.attrs[key] = np.bytes_(value.encode("utf-8")) if isinstance(value, str) else value


def attributes_of(target: h5py.HLObject) -> dict[str, Any]:
    """Return an object's attributes, texts as str, without those that HDF5 and netCDF keep for themselves."""
    found = {}
    for key in sorted(target.attrs):
        if key not in _STRUCTURE:
            value = target.attrs[key]
            found[key] = value.decode("utf-8") if isinstance(value, bytes) else value
    return found


def content_digest(file: h5py.File, digests: Mapping[str, str] | None = None) -> str:
    """Return the SHA-256 over names, types, shapes, dimensions, attributes and data.

    Parameters
    ----------
    digests : mapping
        Those of the data of some variables, if they are known already.
    """
    content: list[Any] = []
    for name in sorted(file):
        dataset = file[name]
        data = (digests or {}).get(name) or _data_digest(dataset)
        listed = {key: np.asarray(value).tolist() for key, value in attributes_of(dataset).items()}
        content.append([name, dataset.dtype.str, dataset.shape, dims_of(file, name), listed, data])
    top = {key: np.asarray(value).tolist() for key, value in attributes_of(file).items() if key != DIGEST}
    return hashlib.sha256(json.dumps([content, top], sort_keys=True).encode()).hexdigest()


def _data_digest(dataset: h5py.Dataset) -> str:
    """Return the SHA-256 of a dataset's values in C order, reading no more than a chunk at a time."""
    digest = hashlib.sha256()
    for part in dataset.iter_chunks() if dataset.chunks else [()]:
        values = read_values(dataset, part)
        texts = values.dtype.kind == "O"
        digest.update(json.dumps(list(values.ravel())).encode() if texts else np.ascontiguousarray(values).data)
    return digest.hexdigest()


def read_values(dataset: h5py.Dataset, part: Part = ()) -> np.ndarray:
    """Return a dataset, or a part of it, in memory, texts as str."""
    return np.asarray(dataset.asstr()[part] if dataset.dtype.kind == "O" else dataset[part])


def dims_of(file: h5py.File, name: str) -> tuple[str, ...]:
    """Return the names of the dimensions of a dataset."""
    dataset = file[name]
    if dataset.is_scale:
        return (name,)
    return tuple(dim[0].name.lstrip("/") for dim in dataset.dims)
