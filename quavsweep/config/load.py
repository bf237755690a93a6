"""From a YAML file to a Sweep; what is wrong is told by file, line, key and what is possible."""

from __future__ import annotations

import difflib
import math
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ValidationError

from quavsweep.config.document import MAX_BYTES, Place, plain, read_yaml
from quavsweep.config.schema import Config, IntegrateSection
from quavsweep.config.sweep import Clock, Sweep
from quavsweep.errors import ConfigError, ModelError
from quavsweep.grid import Axis, Grid
from quavsweep.models import NAMES, Model, load_model

MAX_CELLS = 10**12
MAX_SEGMENTS = 10**5
BATCHES = 64  # batches in transient + duration, unless the config says how long one is
BATCHES_PER_SEGMENT = 4
MAX_TRIED = 4096  # lengths of a batch


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
        raise _first_error(error, place) from error
    return _check(config, place)


def _first_error(error: ValidationError, place: Place) -> ConfigError:
    """Return the error that comes first in the text, in words."""
    found = []
    for item in error.errors(include_url=False):
        keys = tuple(key for key in item["loc"] if key != "[key]")
        section = _section(keys[:-1])
        possible = f"possible keys are {', '.join(section)}" if section else ""
        if item["type"] == "extra_forbidden":
            near = difflib.get_close_matches(str(keys[-1]), section, 1)
            what = "unknown key" + (f", did you mean {near[0]}?" if near else "")
        elif item["type"] == "missing":
            what, possible = "is missing", _describe(keys)
        elif item["type"] == "string_pattern_mismatch":
            what, possible = f"{item['input']!r} is not accepted", f"it may have {_describe(keys)}"
        elif item["type"] in ("dict_type", "model_type"):
            what = "is not a mapping of keys"
            possible = f"possible keys are {', '.join(_section(keys))}" if _section(keys) else ""
        elif item["type"] == "value_error":
            what, possible = str(item["ctx"]["error"]), ""
        else:
            message = item["msg"].removeprefix("Input should be ").removeprefix("a valid ")
            given = _shown(item["input"])
            what = f"{given if len(given) < 40 else given[:37] + '...'} is not accepted"
            possible = f"it should be {message}" if message != item["msg"] else item["msg"]
        # A misspelt key makes another one missing; the misspelt one is what the user has to see.
        found.append((item["type"] == "missing", place.line(keys), keys, what, possible))
    *_, keys, what, possible = min(found, key=lambda row: row[:2])
    return place.error(keys, what, possible)


def _shown(value: Any) -> str:
    """Return a value as text; integers may be too long for that."""
    try:
        return repr(value)
    except ValueError:
        return "a number of thousands of digits"


def _section(keys: tuple[Any, ...]) -> list[str]:
    """Return the keys that the schema has at a place."""
    kind: Any = Config
    for key in keys:
        kind = _model_of(kind)
        if isinstance(kind, type) and issubclass(kind, BaseModel) and key in kind.model_fields:
            kind = kind.model_fields[key].annotation
        elif get_origin(kind) is dict:
            kind = get_args(kind)[1]
        else:
            return []
    kind = _model_of(kind)
    return list(kind.model_fields) if isinstance(kind, type) and issubclass(kind, BaseModel) else []


def _model_of(kind: Any) -> Any:
    """Return the section inside an optional one."""
    if get_origin(kind) in (Union, types.UnionType):
        kind = next(part for part in get_args(kind) if part is not type(None))
    return kind


def _describe(keys: tuple[Any, ...]) -> str:
    """Return the schema's description of a key."""
    if keys == ("model",):
        return f"the catalogue has {', '.join(NAMES)}"
    kind: Any = Config
    for key in keys[:-1]:
        kind = _model_of(kind.model_fields[key].annotation)
    return kind.model_fields[keys[-1]].description or f"it has the keys {', '.join(_section(keys))}"


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
    lyapunov = config.measures.lyapunov
    if lyapunov and lyapunov.exponents > len(model.states):
        keys = ("measures", "lyapunov", "exponents")
        raise place.error(keys, f"{model.name} has {len(model.states)} states", f"1 to {len(model.states)} exponents")
    clock = _clock(config, place)
    warnings = (*_rounding(config.integrate, clock), *_broken_relations(model, fixed, grid))
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


def _clock(config: Config, place: Place) -> Clock:
    """Round all times up to whole blocks, batches and segments.

    Unless the config says how long a batch is, there are 64 to 256 of them, whichever number needs least rounding.
    """
    section, lyapunov = config.integrate, config.measures.lyapunov
    if section.dt > section.duration:
        raise place.error(("integrate", "dt"), f"a step of {section.dt:g} is longer than the duration")
    block = lyapunov.block if lyapunov else 25
    total = section.transient + section.duration
    asked = lyapunov.batch if lyapunov else section.segment
    for length in (total, asked or 0.0, section.segment or 0.0):
        if not length / section.dt < 2**53:
            raise place.error(("integrate",), f"{length / section.dt:.3g} steps are too many", "at most 9e15")
    if asked:
        lengths = range(_whole(asked, block * section.dt), 0, -1)[:1]
    else:
        longest = _whole(min(total / BATCHES, section.segment or total), block * section.dt)
        lengths = range(longest, longest // 4, -1)[:MAX_TRIED]
    clocks = (_rounded(section, block, batch_blocks) for batch_blocks in lengths)
    clock = min(clocks, key=lambda c: round((c.transient + c.duration) / total, 9))
    if clock.segments > MAX_SEGMENTS or clock.steps > 2**53:
        raise place.error(
            ("integrate", "duration"),
            f"{clock.segments} looks and {clock.steps:.3g} steps are too many",
            f"at most {MAX_SEGMENTS} segments; a longer segment or batch makes fewer",
        )
    return clock


def _rounded(section: IntegrateSection, block: int, batch_blocks: int) -> Clock:
    """Return the clock with batches of so many blocks."""
    batch = batch_blocks * block * section.dt
    segment_batches = _whole(section.segment, batch) if section.segment else BATCHES_PER_SEGMENT
    segment = segment_batches * batch
    transient = _whole(section.transient, segment) if section.transient else 0
    return Clock(
        section.dt, block, batch_blocks, segment_batches, transient, transient + _whole(section.duration, segment)
    )


def _rounding(section: IntegrateSection, clock: Clock) -> tuple[str, ...]:
    """Return a sentence if times had to be changed."""
    used = {"transient": clock.transient, "duration": clock.duration}
    changed = [
        f"{key} {getattr(section, key):g} -> {t:g}" for key, t in used.items() if t > getattr(section, key) * (1 + 1e-9)
    ]
    whole = f"whole segments of {clock.segment_steps * clock.dt:g}"
    return (f"rounded up to {whole}: {', '.join(changed)}",) if changed else ()


def _whole(length: float, unit: float) -> int:
    """Return the number of units that cover a length; rounding errors do not add one."""
    return max(1, math.ceil(length / unit * (1 - 1e-12) - 1e-9))
