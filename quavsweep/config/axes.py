"""The axes of a sweep: what their keys must fulfil together, and the grid that they span."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from quavsweep.config.ensemble import make_ensemble
from quavsweep.config.place import Keys, Place
from quavsweep.config.schema import ENSEMBLE, AnyAxis, AxisSection, Config, EnsembleSection, ValuesSection
from quavsweep.config.zipped import AXES, check_zipped, given_values, is_list, is_zipped, make_zipped
from quavsweep.grid import Axis, Grid
from quavsweep.models import Model, Parameter, State

MAX_CELLS = 10**12
EITHER = "an axis is {start, stop, num} or {values}, or {zip} of several quantities"
ONE = "values are [a list], or {start, stop, num}"


def make_grid(config: Config, model: Model, place: Place) -> Grid:
    """Return the grid; sizes are checked before anything is allocated.

    Raises
    ------
    ConfigError
        For an axis whose keys do not fit together.
    """
    for keys, section in given_values(config).items():
        _check_keys(keys, section, place)
        _check_ends(keys, section, place)
        _check_list(keys, section, place)
    check_zipped(config, place)
    _check_size(config, place)
    with np.errstate(over="ignore", invalid="ignore"):
        grid = Grid(tuple(_make_axis(name, section, model) for name, section in config.axes.items()))
    along = {name: values for axis in grid.axes for name, values in axis.quantities.items()}
    for keys, section in given_values(config).items():
        _check_points(keys, along[str(keys[-1])], section, place)
    return grid


def _make_axis(name: str, section: AnyAxis, model: Model) -> Axis:
    if isinstance(section, EnsembleSection):
        return make_ensemble(section.num, section.seed, section.box, model.state_names)
    return make_zipped(name, section) if section.zip is not None else Axis(name, section.points())


def _check_keys(axis: Keys, section: ValuesSection, place: Place) -> None:
    """Refuse an axis that has too few or too many keys."""
    either = ONE if is_zipped(axis) else EITHER
    spaced = [(*axis, key) for key in ("start", "stop", "num") if getattr(section, key) is not None]
    values = (*axis, "values")
    if section.values is not None and spaced:
        first = min([*spaced, values], key=place.line)
        named = " and ".join(place.other(key, first) for key in (spaced if first == values else [values]))
        raise place.error(first, f"cannot stand beside {named}", either)
    missing = [(*axis, key) for key in ("start", "stop", "num") if (*axis, key) not in spaced]
    if section.values is None and missing:
        first, *others = missing if spaced else [values, *missing]
        too = f", and so {'is' if len(others) == 1 else 'are'} {', '.join(str(key[-1]) for key in others)}" * bool(
            others
        )
        raise place.error(first, f"is missing{too}", either)


def _check_ends(axis: Keys, section: ValuesSection, place: Place) -> None:
    """Refuse ends that span nothing, and a logarithmic axis that touches zero."""
    start, stop, spacing = ((*axis, key) for key in ("start", "stop", "spacing"))
    if section.ends is None:
        return
    if section.start == section.stop and section.num != 1:
        what = f"{section.start:g} is also the value of {place.other(stop, start)}"
        raise place.error(start, what, "one value needs num: 1 or values")
    for key, value in ((start, section.start), (stop, section.stop)):
        if section.spacing == "log" and value is not None and value <= 0:
            what = f"{value:g} cannot be on a logarithmic axis, {place.other(spacing, key)}"
            raise place.error(key, what, "it must be above 0")


def _check_list(axis: Keys, section: ValuesSection, place: Place) -> None:
    """Refuse a value that is given twice; a curve may come back to one of a zipped quantity."""
    first: dict[float, int] = {}
    for i, value in enumerate(() if is_zipped(axis) else section.values or ()):
        if first.setdefault(value, i) != i:
            keys, earlier = (*axis, "values", i), (*axis, "values", first[value])
            raise place.error(keys, f"{value:g} is given twice; it is {place.other(earlier, keys)} already")


def _check_size(config: Config, place: Place) -> None:
    """Refuse more cells than an index can count."""
    lengths: dict[Keys, int] = {
        (*AXES, name, "num" if section.num else "zip" if section.zip else "values"): section.length
        for name, section in config.axes.items()
        if isinstance(section, AxisSection)
    }
    lengths |= {(*AXES, ENSEMBLE, "num"): config.ensemble.num} if config.ensemble else {}
    size = math.prod(lengths.values())
    if size <= MAX_CELLS:
        return
    first, *others = sorted(lengths, key=lambda key: -lengths[key])
    named = " and ".join(place.other(key, first) for key in others)
    what = f"{lengths[first]} values, with {named}, make {size:.3g} cells; that is too many"
    raise place.error(first, what, f"at most {MAX_CELLS:.0e}")


def _check_points(axis: Keys, values: tuple[float, ...], section: ValuesSection, place: Place) -> None:
    """Refuse ends between which so many different numbers do not exist."""
    if section.values is not None or (np.isfinite(values).all() and len(set(values)) == len(values)):
        return
    start, stop, num = ((*axis, key) for key in ("start", "stop", "num"))
    named = f"{place.other(start, stop)} and {place.other(num, stop)}"
    raise place.error(stop, f"{section.stop!r}, with {named}, gives values that are not all different and finite")


def check_domains(model: Model, fixed: Mapping[str, float], config: Config, grid: Grid, place: Place) -> None:
    """Refuse parameters and initial states outside the domain in which the model makes sense.

    `fixed` has the values of parameters that do not vary.

    Raises
    ------
    ConfigError
        For the first of them.
    """
    varied = {name: np.asarray(values) for axis in grid.axes for name, values in axis.quantities.items()}
    given = {**model.defaults, **fixed, **config.initial}
    quantities: list[Parameter | State] = [*model.parameters, *model.states]
    for quantity in quantities:
        name = quantity.name
        values = varied[name] if name in varied else np.array([given[name]])
        outside = np.flatnonzero(~np.asarray(quantity.admits(values)))
        if outside.size:
            keys, value = _origin(name, int(outside[0]), config, float(values[outside[0]]))
            what = f"{value:.10g} {quantity.unit} is outside the domain".replace(" 1 is", " is")
            raise place.error(keys, what, f"it must be {quantity.domain}")


def _origin(name: str, index: int, config: Config, value: float) -> tuple[Keys, Any]:
    """Return the key that makes the value of a parameter or initial state what it is, and what it says."""
    keys = config.varied.get(name)
    if keys is None:
        return ("initial" if name in config.initial else "parameters", name), value
    section = given_values(config).get(keys)
    if section is None:  # drawn from a box
        return keys, value
    if section.values is not None:
        return (*keys, *(() if is_list(keys, config) else ("values",)), index), value
    return ((*keys, "start"), value) if index == 0 else ((*keys, "stop"), section.stop)
