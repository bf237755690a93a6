"""From a YAML file to a Sweep; what is wrong is told by file, line, key and what is possible."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from quavsweep.config.complaint import first_error
from quavsweep.config.document import MAX_BYTES, Place, plain, read_yaml
from quavsweep.config.schema import Config
from quavsweep.config.sweep import Sweep
from quavsweep.config.times import choose_clock, rounding
from quavsweep.errors import ConfigError, ModelError
from quavsweep.grid import Axis, Grid
from quavsweep.models import NAMES, Model, load_model

MAX_CELLS = 10**12


def load_sweep(path: Path | str) -> Sweep:
    """Return the sweep that a YAML file describes.

    Raises
    ------
    ConfigError
        With file, line and key, if anything in it cannot be read or does not make sense.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            text = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"cannot be read: {error.strerror}", str(path)) from error
    if len(text) > MAX_BYTES:
        raise ConfigError(f"is larger than {MAX_BYTES} bytes", str(path))
    return parse_sweep(text, str(path))


def parse_sweep(text: str | bytes, where: str = "config") -> Sweep:
    """Return the sweep that a YAML text describes; `where` names it in errors.

    Raises
    ------
    ConfigError
        See `load_sweep`.
    """
    tree = read_yaml(text, where)
    place = Place(where, tree)
    try:
        config = Config.model_validate(plain(tree))
    except ValidationError as error:
        raise first_error(error, place) from error
    return _check(config, place)


def _check(config: Config, place: Place) -> Sweep:
    """Check what a schema cannot: names, domains, sizes, clocks."""
    try:
        model = load_model(config.model)
    except ModelError as error:
        raise place.error(("model",), error.what, f"the catalogue has {', '.join(NAMES)}") from error
    _check_names(config, model, place)
    size = math.prod((axis.num or len(axis.values or ())) for axis in config.axes.values())
    if size > MAX_CELLS:
        raise place.error(("axes",), f"{size:.3g} cells are too many", f"at most {MAX_CELLS:.0e}")
    grid = Grid(tuple(Axis(name, axis.points()) for name, axis in config.axes.items()))
    for axis in grid.axes:
        if not np.isfinite(axis.values).all() or len(set(axis.values)) < len(axis):
            raise place.error(
                ("axes", axis.name), "its values are not all different and finite", "change start or stop"
            )
    fixed = {n: float(config.parameters.get(n, d)) for n, d in model.defaults.items() if n not in config.axes}
    _check_domains(model, fixed, grid, place)
    clock = choose_clock(config, place)
    problem = config.measures.problem(model, clock)
    if problem is not None:
        raise place.error(("measures", *problem.key.split(".")), problem.what, problem.possible)
    measures = config.measures.rounded(model, clock)
    warnings = (
        *rounding(config.integrate, clock),
        *config.measures.changes(measures),
        *_broken_relations(model, fixed, grid),
    )
    config = config.model_copy(update={"measures": measures})
    return Sweep(config, model, grid, clock, fixed, warnings)


def _check_names(config: Config, model: Model, place: Place) -> None:
    states, parameters = model.state_names, model.parameter_names
    for section, known, what in (
        ("parameters", parameters, "parameter"),
        ("initial", states, "state"),
        ("axes", (*parameters, *states), "parameter or state"),
    ):
        for name in getattr(config, section):
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                hint = f"did you mean {near[0]}? " if near else ""
                raise place.error(
                    (section, name), f"{model.name} has no such {what}", f"{hint}it has {', '.join(known)}"
                )
            if section != "axes" and name in config.axes:
                raise place.error((section, name), "is fixed here and varied in axes", "keep one of the two")
    missing = [name for name in states if name not in config.initial and name not in config.axes]
    if missing:
        raise place.error(("initial",), f"{', '.join(missing)} missing", "give every state that is not an axis")


def _check_domains(model: Model, fixed: Mapping[str, float], grid: Grid, place: Place) -> None:
    varied = {axis.name: axis.values for axis in grid.axes}
    for parameter in model.parameters:
        section = "axes" if parameter.name in varied else "parameters"
        for value in varied.get(parameter.name, (fixed.get(parameter.name, 0.0),)):
            if not parameter.admits(value):
                what = f"{value:g} {parameter.unit} is outside the domain".replace(" 1 is", " is")
                raise place.error((section, parameter.name), what, f"it must be {parameter.domain}")


def _broken_relations(model: Model, fixed: Mapping[str, float], grid: Grid) -> tuple[str, ...]:
    """Return a sentence for each relation of the model that some cell breaks."""
    sentences = []
    for relation in model.relations:
        axes = [axis for axis in grid.axes if axis.name in relation.parameters]
        mesh = np.meshgrid(*(_sample(axis.values) for axis in axes), indexing="ij", sparse=True)
        values = {axis.name: part for axis, part in zip(axes, mesh, strict=True)}
        holds = np.asarray(relation.holds(**{name: values.get(name, fixed.get(name)) for name in relation.parameters}))
        if not holds.all():
            share = "" if holds.ndim == 0 else f" in {100 * (1 - holds.mean()):.3g} % of the cells"
            sentences.append(f"{relation.text} does not hold{share}; {relation.meaning}")
    return tuple(sentences)


def _sample(values: tuple[float, ...]) -> np.ndarray:
    """Return at most 200 values of an axis, evenly chosen, with both ends."""
    chosen = np.unique(np.linspace(0, len(values) - 1, 200).round().astype(int))
    return np.asarray(np.asarray(values)[chosen])
