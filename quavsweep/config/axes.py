"""The axes of a sweep: what their keys must fulfil together, and the grid that they span."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from quavsweep.config.ensemble import BOX, make_ensemble
from quavsweep.config.place import Keys, Place
from quavsweep.config.schema import ENSEMBLE, AnyAxis, AxisSection, Config, EnsembleSection
from quavsweep.grid import Axis, Grid
from quavsweep.models import Model, Parameter, State

MAX_CELLS = 10**12
EITHER = "an axis is {start, stop, num} or {values}"


def make_grid(config: Config, model: Model, place: Place) -> Grid:
    """Return the grid; sizes are checked before anything is allocated.

    Raises
    ------
    ConfigError
        For an axis whose keys do not fit together.
    """
    for name, section in _spaced(config).items():
        _check_keys(("axes", name), section, place)
        _check_ends(("axes", name), section, place)
        _check_list(("axes", name), section, place)
    _check_size(config, place)
    with np.errstate(over="ignore", invalid="ignore"):
        grid = Grid(tuple(_make_axis(name, section, model) for name, section in config.axes.items()))
    spaced = _spaced(config)
    for axis in grid.axes:
        if axis.name in spaced:
            _check_points(axis, spaced[axis.name], place)
    return grid


def _spaced(config: Config) -> dict[str, AxisSection]:
    """Return the axes whose values the config gives."""
    return {name: section for name, section in config.axes.items() if isinstance(section, AxisSection)}


def _make_axis(name: str, section: AnyAxis, model: Model) -> Axis:
    if isinstance(section, EnsembleSection):
        return make_ensemble(section.num, section.seed, section.box, model.state_names)
    return Axis(name, section.points())


def _check_keys(axis: Keys, section: AxisSection, place: Place) -> None:
    """Refuse an axis that has too few or too many keys."""
    spaced = [(*axis, key) for key in ("start", "stop", "num") if getattr(section, key) is not None]
    values = (*axis, "values")
    if section.values is not None and spaced:
        first = min([*spaced, values], key=place.line)
        named = " and ".join(place.other(key, first) for key in (spaced if first == values else [values]))
        raise place.error(first, f"cannot stand beside {named}", EITHER)
    missing = [(*axis, key) for key in ("start", "stop", "num") if (*axis, key) not in spaced]
    if section.values is None and missing:
        first, *others = missing if spaced else [values, *missing]
        too = f", and so {'is' if len(others) == 1 else 'are'} {', '.join(str(key[-1]) for key in others)}" * bool(
            others
        )
        raise place.error(first, f"is missing{too}", EITHER)


def _check_ends(axis: Keys, section: AxisSection, place: Place) -> None:
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


def _check_list(axis: Keys, section: AxisSection, place: Place) -> None:
    """Refuse a value that is given twice."""
    first: dict[float, int] = {}
    for i, value in enumerate(section.values or ()):
        if first.setdefault(value, i) != i:
            keys, earlier = (*axis, "values", i), (*axis, "values", first[value])
            raise place.error(keys, f"{value:g} is given twice; it is {place.other(earlier, keys)} already")


def _check_size(config: Config, place: Place) -> None:
    """Refuse more cells than an index can count."""
    lengths = {name: section.num or len(section.values or ()) for name, section in _spaced(config).items()}
    lengths |= {ENSEMBLE: config.ensemble.num} if config.ensemble else {}
    size = math.prod(lengths.values())
    if size <= MAX_CELLS:
        return
    keys = [("axes", name, "num" if config.axes[name].num else "values") for name in lengths]
    first, *others = sorted(keys, key=lambda key: -lengths[key[1]])
    named = " and ".join(place.other(key, first) for key in others)
    what = f"{lengths[first[1]]} values, with {named}, make {size:.3g} cells; that is too many"
    raise place.error(first, what, f"at most {MAX_CELLS:.0e}")


def _check_points(axis: Axis, section: AxisSection, place: Place) -> None:
    """Refuse ends between which so many different numbers do not exist."""
    if np.isfinite(axis.values).all() and len(set(axis.values)) == len(axis):
        return
    start, stop, num = (("axes", axis.name, key) for key in ("start", "stop", "num"))
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
    section = _spaced(config).get(name)
    if section is None:
        if config.ensemble is not None and name in config.ensemble.box:
            return (*BOX, name), value
        return ("initial" if name in config.initial else "parameters", name), value
    if section.values is not None:
        return ("axes", name, "values", index), value
    return (("axes", name, "start"), value) if index == 0 else (("axes", name, "stop"), section.stop)
