"""Result: what a reader opens, finished or not."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from quavsweep.codes import STATUS, Status
from quavsweep.config import Sweep, load_sweep
from quavsweep.config.schema import ENSEMBLE
from quavsweep.errors import ConfigError, DamageError
from quavsweep.grid import Axis, Grid
from quavsweep.provenance import identify
from quavsweep.store import (
    Part,
    RunFolder,
    ShardSet,
    Stored,
    Variables,
    code_counts,
    looks_published,
    read_result,
    thin,
)
from quavsweep.store.doubt import doubted, sweep_of
from quavsweep.store.fit import check_evidence
from quavsweep.store.outcome import HORIZON, outcome_so_far

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Result:
    """Regions, exponents and times over the grid of a sweep.

    Parameters
    ----------
    sweep : Sweep
        What was asked for. Its name is not stored in result files; it is that of the folder's config, if there is one.
    stored : Stored
        Arrays, dimensions and attributes by variable. Those of a file are read when they are first asked for.
    fixed : tuple of str
        Axes that were left out by `at`; their values are among the sweep's parameters and initial states.
    thinned_from : tuple of int
        Where only some of the cells are in it, how many values the axes had.
    """

    sweep: Sweep
    stored: Stored
    fixed: tuple[str, ...] = ()
    thinned_from: tuple[int, ...] = ()

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a variable or coordinate, axes first."""
        if name not in self.stored.data:
            raise KeyError(f"there is no {name}; there are {', '.join(self.stored.data)}")
        return self.stored.data[name]

    def part(self, name: str, part: Part) -> np.ndarray:
        """Return a part of a variable, by slices of the leading axes; no more of a file is read than it needs."""
        return self.stored.part(name, part)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.stored.data)

    def __contains__(self, name: str) -> bool:
        """Whether the result has a variable or coordinate of that name."""
        return name in self.stored.data

    def __repr__(self) -> str:
        """Say what the result is of, not all its numbers."""
        shape = " x ".join(f"{axis.name}: {len(axis)}" for axis in self.sweep.grid.axes) or "one cell"
        return f"<quavsweep.Result of {self.sweep.model.name}, {shape}>"

    def _repr_png_(self) -> bytes | None:
        """Return the result's figure, which notebooks show; None if it has none."""
        from quavsweep.plot import picture

        try:
            return picture(self)
        except ConfigError:
            return None

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the variables, without coordinates."""
        varied = self.sweep.grid.quantities
        return tuple(name for name, dims in self.stored.dims.items() if name not in dims and name not in varied)

    @property
    def horizon(self) -> float | None:
        """The time up to which it tells, where a run that went on is asked for less."""
        horizon = self.stored.file_attributes.get(HORIZON)
        return None if horizon is None else float(horizon)

    @property
    def complete(self) -> bool:
        """Whether every cell has been computed."""
        return not code_counts(self.stored, "status", STATUS)[Status.NOT_COMPUTED]

    def at(self, **values: float) -> Result:
        """Return the result with these axes left out, at their values nearest to those given.

        Raises
        ------
        ConfigError
            If there is no such axis, or a value lies beyond its ends.
        """
        names = [axis.name for axis in self.sweep.grid.axes]
        index: dict[str, int] = {}
        for name, value in values.items():
            axis = self._axis_of(name)
            along = np.asarray(axis.values if name == axis.name else axis.quantities[name])
            if not along.min() <= value <= along.max():
                raise ConfigError(f"{name} has no value {value:g}", possible=f"{along.min():g} to {along.max():g}")
            nearest = int(np.argmin(np.abs(along - value)))
            if index.setdefault(axis.name, nearest) != nearest:
                what = f"{name} = {value:g} is at {axis.name} = {nearest}, not at {index[axis.name]}"
                raise ConfigError(what, possible="one of the quantities along a curve is enough")
        whole = self.stored

        def read(variable: str, part: Part) -> np.ndarray:
            rest = iter(part)
            where = (index[dim] if dim in index else next(rest, slice(None)) for dim in whole.dims[variable])
            return np.asarray(whole.part(variable, tuple(where)))

        gone = {*index, *(name for axis in self.sweep.grid.axes if axis.name in index for name in axis.quantities)}
        dims = {v: tuple(d for d in of if d not in index) for v, of in whole.dims.items() if v not in gone}
        data = Variables(tuple(dims), read)
        axes = tuple(axis for axis in self.sweep.grid.axes if axis.name not in index)
        chosen = {n: v for name, i in index.items() for n, v in self.sweep.grid.axes[names.index(name)].at(i).items()}
        sweep, fixed = self.sweep.with_fixed(chosen, Grid(axes)), (*self.fixed, *chosen)
        return Result(sweep, replace(whole, data=data, dims=dims), fixed)

    def thinned(self, chosen: Mapping[str, range]) -> Result:
        """Return the result at some values of each of its axes, by their indices; only these are read."""
        axes = self.sweep.grid.axes
        sweep = replace(self.sweep, grid=Grid(tuple(axis.picked(chosen[axis.name]) for axis in axes)))
        return Result(sweep, thin(self.stored, chosen), self.fixed, tuple(len(axis) for axis in axes))

    def _axis_of(self, name: str) -> Axis:
        """Return the axis of that name, or the curve along which that quantity varies; not that of drawn starts."""
        axes = self.sweep.grid.axes
        for axis in axes:
            if name == axis.name or (axis.name != ENSEMBLE and name in axis.quantities):
                return axis
        known = [name for axis in axes for name in (axis.name, *(n for n, _ in axis.along if axis.name != ENSEMBLE))]
        raise ConfigError(f"there is no axis {name}", possible=f"the axes are {', '.join(known) or 'none'}")

    @property
    def points(self) -> Result:
        """What all starts of a parameter point say together: the result over the axes of parameters alone."""
        sweep, starts, whole = self.sweep, set(self.sweep.start_axes), self.stored
        gone = starts | {name for axis in sweep.grid.axes if axis.name in starts for name in axis.quantities}
        dims = {v: of for v, of in whole.dims.items() if v not in gone and not starts & set(of)}
        stored = replace(whole, data=Variables(tuple(dims), whole.part), dims=dims)
        return Result(replace(sweep, grid=sweep.points), stored, self.fixed)

    def to_xarray(self) -> xarray.Dataset:
        """Return the result as an xarray Dataset (needs the extra `xarray`)."""
        import xarray

        arrays = {
            name: xarray.Variable(dims, self.stored.data[name], self.stored.attributes[name])
            for name, dims in self.stored.dims.items()
        }
        dataset = xarray.Dataset(arrays, attrs=self.stored.file_attributes)
        return dataset.set_coords([name for name in self.sweep.grid.quantities if name in arrays])


def open_result(path: Path | str, horizon: float | None = None) -> Result:
    """Open a result file, or a run's folder: its result, or what its shards give if there is none yet.

    Parameters
    ----------
    path : Path
    horizon : float, optional
        A time from t = 0, whole segments beyond the transient: what a run that ends there would have said, by the
        folder's evidence. What is stored of the end alone is not in it: what other measures recorded, the
        `final_state` of cells that went on, and an ensemble's tangent vectors beyond the end, so that starts which
        that run would have called chaos are undecided.

    Raises
    ------
    ConfigError
        If there is nothing to open.
    DamageError
        If what is stored is not what was written.
    """
    path = Path(path)
    if horizon is not None and path.name == "result.h5":
        path = path.parent
    if path.is_file():
        if horizon is not None:
            raise ConfigError("a horizon needs the evidence of a run", str(path), "name the folder of the run")
        if not looks_published(path):
            raise ConfigError("is not a result file", str(path), "name a result.h5 or the folder of a run")
        return _from_file(path)
    folder = RunFolder(path)
    if horizon is None and folder.result.is_file():
        return _from_file(folder.result)
    folder.must_exist()
    foreign = not folder.is_own
    with doubted(path, foreign):
        result = _from_shards(folder, horizon, foreign)
        return replace(result, stored=replace(result.stored, foreign=foreign))


def _from_shards(folder: RunFolder, horizon: float | None, foreign: bool) -> Result:
    sweep = load_sweep(folder.config)
    if horizon is not None:
        sweep.require_evidence("a horizon", str(folder.path))
    if foreign:
        check_evidence(sweep, folder.path)
    identity = folder.present_identity(identify(sweep))
    shards = ShardSet.scan(folder, sweep, identity)
    if horizon is None:
        return Result(sweep, outcome_so_far(shards))
    steps = sweep.steps_at(horizon)
    return Result(sweep.until(steps).without_effort(), outcome_so_far(shards, steps))


def _from_file(path: Path) -> Result:
    stored = read_result(path)
    sweep = sweep_of(stored.file_attributes, path)
    return Result(replace(sweep, config=sweep.config.model_copy(update=_told(path))), stored)


def _told(path: Path) -> dict[str, Any]:
    """Return what a result file does not hold of its config: name and figure, as the folder's config says, if any."""
    if path.name != "result.h5":
        return {"name": path.stem}
    beside = RunFolder(path.parent).config
    if beside.is_file():  # a pipe would be waited for
        with contextlib.suppress(ConfigError, DamageError):
            config = load_sweep(beside).config
            return {"name": config.name, "plot": config.plot}
    return {"name": path.absolute().parent.name}
