"""One cell of a sweep on its own, to the bit the map's: its result, its orbit, and how its exponents converge."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from quavsweep.classify import classify, convergence
from quavsweep.config import Sweep
from quavsweep.errors import ConfigError
from quavsweep.grid import Axis, Grid, Tile
from quavsweep.integrate import continue_cells, integrate_tile
from quavsweep.kernels.compiler import default_lanes
from quavsweep.measures import Evidence, Measures, Orbit
from quavsweep.models import Parameter, State
from quavsweep.passes import with_passes
from quavsweep.plan import make_plan

MOST_TIMES = 200_000  # of the orbit
SAME = 1e-9  # a value this near to one of the axis, as a share of its range, means that one


@dataclass(frozen=True)
class Point:
    """What a single cell does.

    Parameters
    ----------
    sweep : Sweep
        Of this cell alone; it has no axes.
    values : dict of arrays
        The result's variables, without dimensions for axes: `region` (), `lyapunov` (K,), `final_state` (D,) ...
    time : (n,) float64
        Times of the orbit, evenly spaced from 0 to where the integration ended, in the model's time.
    orbit : (n, D) float64
        States at these times.
    averaged_until : (m,) float64
        Times until which the exponents below are averaged; the average begins after the transient, or at 0 where
        the cell ended within it.
    exponents, errors : (m, K) float64
        Averages until these times, and their standard errors (inf where there are too few batches).
    indices : tuple of int, optional
        Where the cell lies in the grid of the sweep that it was taken from; None if it is none of its cells.
    chosen : tuple of str
        The quantities that were given a value.
    """

    sweep: Sweep
    values: dict[str, np.ndarray]
    time: np.ndarray
    orbit: np.ndarray
    averaged_until: np.ndarray
    exponents: np.ndarray
    errors: np.ndarray
    indices: tuple[int, ...] | None = None
    chosen: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Say which cell it is, not all its numbers."""
        values = {**self.sweep.parameters, **self.sweep.config.initial}
        at = ", ".join(f"{name} = {values[name]:g}" for name in self.chosen)
        return f"<quavsweep.Point of {self.sweep.model.name} at {at or 'the defaults'}>"


def compute_point(sweep: Sweep, values: Mapping[str, float], stopped: Callable[[], bool] | None = None) -> Point:
    """Integrate one cell of a sweep, or one beside its grid.

    Parameters
    ----------
    sweep : Sweep
    values : mapping
        A value for each axis, by name, in its unit; other parameters and initial states may be given as well. A
        value next to one of the axis (to 1e-9 of its range) means that one.

    stopped : callable, optional
        Asked now and then; once it is true, the integration stops.

    Returns
    -------
    Point
        Its `values` equal those of the map to the bit, if it is a cell of the grid.

    Raises
    ------
    ConfigError
        If an axis has no value, or a value has no place in the model.
    StoppedError
        If `stopped()` became true.
    """
    stopped = stopped or _never
    single, indices = _single(sweep, values)
    evidence = _integrated(single, stopped)
    result = {name: array[0] for name, array in classify(single, evidence).items()}
    if sweep.measures.lyapunov:
        until, exponents, errors = (array[0] for array in convergence(single, evidence))
    else:
        until, exponents, errors = np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0))
    time, orbit = _orbit(single, int(evidence["steps"][0]), stopped)
    numbered = {q for axis in sweep.grid.axes if axis.name in values for q in axis.quantities}
    asked = numbered.intersection(single.parameters) | set(values)
    named = tuple(name for name in (*single.parameters, *single.config.initial) if name in asked)
    return Point(single, result, time, orbit, until, exponents, errors, indices, named)


def _never() -> bool:
    return False


def _integrated(sweep: Sweep, stopped: Callable[[], bool]) -> Evidence:
    """Return the evidence of the one cell of a sweep, with the passes of the effort."""
    plan = make_plan(sweep, default_lanes())

    def go_on(begin: int, end: int, evidence: Evidence) -> Evidence:
        return continue_cells(plan.until(end), evidence, stopped)

    return with_passes(sweep, integrate_tile(plan, Tile(0, 0, 1), stopped), go_on)[0]


def _orbit(single: Sweep, steps: int, stopped: Callable[[], bool]) -> tuple[np.ndarray, np.ndarray]:
    """Return times and states of the orbit; the states do not depend on what else is measured."""
    clock, steps = single.clock, max(1, steps)  # a cell may leave the domain within its first step
    every = -(-steps // MOST_TIMES)
    measure = Orbit(every=every * clock.dt, until=steps * clock.dt)
    alone = dataclasses.replace(single, config=single.config.model_copy(update={"measures": Measures(orbit=measure)}))
    return alone.dimensions["time"].values, _integrated(alone, stopped)["orbit"][0]


def _single(sweep: Sweep, values: Mapping[str, float]) -> tuple[Sweep, tuple[int, ...] | None]:
    """Return the sweep of one cell, and where it lies in the grid."""
    axes = {axis.name: axis for axis in sweep.grid.axes}
    for name, value in values.items():
        _check(sweep, name, value)
    chosen = {name: value for name, value in values.items() if name not in axes or not axes[name].along}
    own, indices = {**sweep.parameters, **sweep.config.initial}, []
    for axis in axes.values():
        if axis.name in values:
            index = _index(axis, values[axis.name])
        elif set(axis.quantities) <= set(values):
            index = _common_index(axis, values)
        else:
            along = f", or {' '.join(f'{n}=...' for n in axis.quantities)}" if axis.along else ""
            possible = f"give {', '.join(f'{n}=...' for n in axes)}{along}"
            raise ConfigError(f"{axis.name} has no value", possible=possible)
        if index is not None:
            indices.append(index)
            own |= axis.at(index)
            given = chosen if axis.along else {}  # a state that is given beside the number of a start wins
            chosen |= {name: value for name, value in axis.at(index).items() if name not in given}
    on_grid = len(indices) == len(axes) and all(own.get(name) == value for name, value in chosen.items())
    return sweep.with_fixed(chosen, Grid(())), tuple(indices) if on_grid else None


def _index(axis: Axis, value: float) -> int | None:
    """Return the index of the value of an axis that is meant, None if there is none and one beside it makes sense."""
    along = np.asarray(axis.values)
    nearest = int(np.argmin(np.abs(along - value)))
    if abs(along[nearest] - value) <= SAME * max(float(np.ptp(along)), abs(value)):
        return nearest
    if axis.along:
        raise ConfigError(f"{axis.name} has no number {value:g}", possible=f"a whole number from 0 to {along[-1]}")
    return None


def _common_index(axis: Axis, values: Mapping[str, float]) -> int | None:
    """Return the index at which all quantities along an axis have the values that are given, None if there is none."""
    near = np.ones(len(axis), dtype=bool)
    for name, known in axis.quantities.items():
        along, value = np.asarray(known), values[name]
        near &= np.abs(along - value) <= SAME * max(float(np.ptp(along)), abs(value))
    return int(np.argmax(near)) if near.any() else None


def _check(sweep: Sweep, name: str, value: float) -> None:
    """Refuse what is no quantity of the model, or beyond its domain."""
    model = sweep.model
    if any(axis.name == name and axis.along for axis in sweep.grid.axes):
        return
    names = (*model.parameter_names, *model.state_names)
    if name not in names:
        raise ConfigError(f"{model.name} has no {name}", possible=f"it has {', '.join(names)}")
    quantity = model.quantity(name)
    assert isinstance(quantity, Parameter | State)
    if not np.isfinite(value) or not quantity.admits(value):
        raise ConfigError(f"{name} cannot be {value:g}", possible=f"it must be {quantity.domain or 'finite'}")
