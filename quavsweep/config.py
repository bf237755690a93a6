"""YAML text to a frozen Sweep; every check of a user's input lives here."""

from __future__ import annotations

import difflib
import io
import math
import types
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedBase
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent, ScalarEvent

from quavsweep.errors import ConfigError, ModelError
from quavsweep.grid import Axis, Grid
from quavsweep.kernels.method import METHODS, ButcherTable
from quavsweep.measures import Measures
from quavsweep.models import NAMES, Model, load_model

MAX_BYTES = 2**20
MAX_DEPTH = 20
MAX_AXIS = 10**6
MAX_CELLS = 10**12
MAX_SEGMENTS = 10**5
BATCHES = 64  # batches in transient + duration, unless the config says how long one is
BATCHES_PER_SEGMENT = 4

_STRICT = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$")]


class AxisSection(BaseModel):
    """One axis: evenly (or logarithmically) spaced values, or a list."""

    model_config = _STRICT

    start: float | None = Field(default=None, description="first value")
    stop: float | None = Field(default=None, description="last value")
    num: int | None = Field(default=None, ge=1, le=MAX_AXIS, description="number of values")
    spacing: Literal["linear", "log"] = Field(default="linear", description="how the values are spaced")
    values: list[float] | None = Field(
        default=None, min_length=1, max_length=MAX_AXIS, description="the values themselves"
    )

    @property
    def ends(self) -> tuple[float, float, int] | None:
        """Start, stop and number of values, unless one of them is missing."""
        if self.start is None or self.stop is None or self.num is None:
            return None
        return self.start, self.stop, self.num

    @model_validator(mode="after")
    def _complete(self) -> AxisSection:
        if self.values is not None:
            if (self.start, self.stop, self.num) != (None, None, None):
                raise ValueError("an axis is either {start, stop, num} or {values}, not both")
            if len(set(self.values)) != len(self.values):
                raise ValueError("a value is given twice")
        elif self.ends is None:
            raise ValueError("an axis is {start, stop, num} or {values}")
        else:
            start, stop, num = self.ends
            if num > 1 and start == stop:
                raise ValueError("start and stop are equal; one value needs num: 1 or values")
            if self.spacing == "log" and not (start > 0 and stop > 0):
                raise ValueError("a logarithmic axis needs start and stop above 0")
        return self

    def points(self) -> tuple[float, ...]:
        """Return the values of the axis."""
        spaced = np.geomspace if self.spacing == "log" else np.linspace
        return tuple(float(value) for value in (self.values or spaced(*self.ends or (0.0, 0.0, 0))))


class IntegrateSection(BaseModel):
    """How the equations are integrated; times in the model's unit."""

    model_config = _STRICT

    method: Literal["rk4"] = Field(default="rk4", description="Runge-Kutta method")
    dt: float = Field(gt=0, description="step")
    transient: float = Field(default=0.0, ge=0, description="time before exponents are averaged")
    duration: float = Field(gt=0, description="time over which they are averaged")
    segment: float | None = Field(default=None, gt=0, description="stretch between two looks at a cell")


class Thresholds(BaseModel):
    """Thresholds of the classification; changing them needs no new integration."""

    model_config = _STRICT

    errors: float = Field(default=3.0, gt=0, description="an exponent beyond so many standard errors is not zero")
    neutral: float = Field(default=5.0, ge=0, description="nor is one beyond this growth of ln over the time averaged")


class Config(BaseModel):
    """A sweep as the user writes it."""

    model_config = _STRICT

    name: Name = Field(description="letters, digits, . _ -")
    model: str = Field(description="a model of the catalogue")
    parameters: dict[str, float] = Field(default_factory=dict, description="what differs from the model's defaults")
    initial: dict[str, float] = Field(default_factory=dict, description="initial state")
    axes: dict[str, AxisSection] = Field(default_factory=dict, description="what varies, the last axis fastest")
    integrate: IntegrateSection
    measures: Measures = Field(default_factory=Measures, description="what is recorded")
    stop_early: bool = Field(default=True, description="end a cell once its end is certified")
    classify: Thresholds = Field(default_factory=Thresholds, description="thresholds of the classification")


@dataclass(frozen=True)
class Clock:
    """All lengths of time in whole steps and whole multiples of each other.

    Parameters
    ----------
    dt : float
        Step, in the model's time.
    block : int
        Steps between two orthonormalisations.
    batch_blocks : int
        Blocks per batch, the window of an error bar.
    segment_batches : int
        Batches per segment, the stretch between two looks.
    transient_segments, segments : int
        Segments before averaging begins, and in all.
    """

    dt: float
    block: int
    batch_blocks: int
    segment_batches: int
    transient_segments: int
    segments: int

    @property
    def batch_steps(self) -> int:
        """Steps per batch."""
        return self.block * self.batch_blocks

    @property
    def segment_steps(self) -> int:
        """Steps per segment."""
        return self.batch_steps * self.segment_batches

    @property
    def steps(self) -> int:
        """Steps in all."""
        return self.segment_steps * self.segments

    @property
    def transient(self) -> float:
        """Time before averaging begins."""
        return self.segment_steps * self.transient_segments * self.dt

    @property
    def duration(self) -> float:
        """Time over which exponents are averaged."""
        return self.segment_steps * (self.segments - self.transient_segments) * self.dt


@dataclass(frozen=True)
class Sweep:
    """A config that has passed every check, with its model, grid and clock."""

    config: Config
    model: Model
    grid: Grid
    clock: Clock
    parameters: Mapping[str, float]
    warnings: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the sweep."""
        return self.config.name

    @property
    def method(self) -> ButcherTable:
        """The Runge-Kutta table."""
        return METHODS[self.config.integrate.method]

    @property
    def measures(self) -> Measures:
        """What is recorded."""
        return self.config.measures

    @property
    def extents(self) -> dict[str, int]:
        """Lengths of the dimensions that evidence has beyond the cell."""
        return {
            "state": len(self.model.states),
            "exponent": self.measures.vectors,
            "batch": self.clock.segments * self.clock.segment_batches,
            "segment": self.clock.segments,
        }

    def canonical(self) -> dict[str, Any]:
        """Return the config with every default and every rounded time written out; loading it gives the same sweep."""
        data = self.config.model_dump(mode="json", exclude_none=True)
        clock = self.clock
        data["parameters"] = dict(self.parameters)
        data["initial"] = {name: data["initial"][name] for name in self.model.state_names if name in data["initial"]}
        data["integrate"] |= {
            "transient": clock.transient,
            "duration": clock.duration,
            "segment": clock.segment_steps * clock.dt,
        }
        if "lyapunov" in data["measures"]:
            data["measures"]["lyapunov"]["batch"] = clock.batch_steps * clock.dt
        return data


def load_sweep(path: Path) -> Sweep:
    """Return the sweep that a YAML file describes.

    Raises
    ------
    ConfigError
        With file, line and key, if anything in it cannot be read or does not make sense.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ConfigError(f"is larger than {MAX_BYTES} bytes", str(path))
        text = path.read_bytes()
    except OSError as error:
        raise ConfigError(f"cannot be read: {error.strerror}", str(path)) from error
    return parse_sweep(text, str(path))


def parse_sweep(text: str | bytes, where: str = "config") -> Sweep:
    """Return the sweep that a YAML text describes; `where` names it in errors.

    Raises
    ------
    ConfigError
        See `load_sweep`.
    """
    tree = _read_yaml(text, where)
    place = _Place(where, tree)
    try:
        config = Config.model_validate(_plain(tree))
    except ValidationError as error:
        raise _first_error(error, place) from error
    return _check(config, place)


def dump_config(data: Mapping[str, Any]) -> str:
    """Return a canonical config as YAML text."""
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 120
    yaml.dump(dict(data), stream)
    return stream.getvalue()


class _Place:
    """Finds the line of a key in the text."""

    def __init__(self, where: str, tree: Any) -> None:
        self.where, self.tree = where, tree

    def line(self, keys: tuple[Any, ...]) -> int:
        """Return the line of the innermost of these keys that the text has, counted from 1."""
        node, line = self.tree, 1
        for key in keys:
            try:
                line = node.lc.data[key][0] + 1
                node = node[key]
            except (AttributeError, KeyError, IndexError, TypeError):
                break
        return int(line)

    def error(self, keys: tuple[Any, ...], what: str, possible: str = "") -> ConfigError:
        """Return the error that names file, line and key."""
        key = ".".join(str(k) for k in keys)
        where = f"{self.where}:{self.line(keys)}" + (f": {key}" if key else "")
        return ConfigError(what, where, possible)


def _read_yaml(text: str | bytes, where: str) -> Any:
    """Return the tree of a YAML text with line numbers; tags, anchors, aliases and depth are refused before loading."""
    try:
        if isinstance(text, bytes):
            text = text.decode("utf-8")
        yaml = YAML(typ="rt", pure=True)
        depth = 0
        for event in yaml.parse(io.StringIO(text)):
            line = f"{where}:{event.start_mark.line + 1}"
            if isinstance(event, AliasEvent) or getattr(event, "anchor", None) is not None:
                raise ConfigError("anchors and aliases are not allowed", line)
            if isinstance(event, ScalarEvent | CollectionStartEvent) and event.tag is not None:
                raise ConfigError("tags are not allowed", line)
            depth += isinstance(event, CollectionStartEvent) - isinstance(event, CollectionEndEvent)
            if depth > MAX_DEPTH:
                raise ConfigError(f"nested deeper than {MAX_DEPTH}", line)
        tree = YAML(typ="rt", pure=True).load(text)
    except UnicodeDecodeError as error:
        raise ConfigError("is not UTF-8 text", where) from error
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark is not None else ""
        problem = " ".join((error.problem or "cannot be parsed").split())
        raise ConfigError(problem, f"{where}{line}") from error
    except (YAMLError, ValueError, RecursionError) as error:
        raise ConfigError("is not YAML: " + " ".join(str(error).split())[:120], where) from error
    if not isinstance(tree, dict):
        raise ConfigError("is not a mapping of keys", f"{where}:1", f"keys are {', '.join(Config.model_fields)}")
    return tree


def _plain(node: Any) -> Any:
    """Return YAML's nodes as plain Python values."""
    if isinstance(node, dict):
        return {_plain(key): _plain(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [_plain(item) for item in node]
    for kind in (bool, int, float, str):
        if isinstance(node, kind):
            return kind(node)
    return None if node is None or isinstance(node, CommentedBase) else node


def _first_error(error: ValidationError, place: _Place) -> ConfigError:
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
        elif item["type"] == "value_error":
            what, possible = str(item["ctx"]["error"]), ""
        else:
            message = item["msg"].removeprefix("Input should be ").removeprefix("a valid ")
            given = repr(item["input"])
            what = f"{given if len(given) < 40 else given[:37] + '...'} is not accepted"
            possible = f"it should be {message}" if message != item["msg"] else item["msg"]
        # A misspelt key makes another one missing; the misspelt one is what the user has to see.
        found.append((item["type"] == "missing", place.line(keys), keys, what, possible))
    *_, keys, what, possible = min(found, key=lambda row: row[:2])
    return place.error(keys, what, possible)


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
    kind: Any = Config
    for key in keys[:-1]:
        kind = _model_of(kind.model_fields[key].annotation)
    return kind.model_fields[keys[-1]].description or f"it has the keys {', '.join(_section(keys))}"


def _check(config: Config, place: _Place) -> Sweep:
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
    fixed = {n: float(config.parameters.get(n, d)) for n, d in model.defaults.items() if n not in config.axes}
    _check_domains(model, fixed, grid, place)
    lyapunov = config.measures.lyapunov
    if lyapunov and lyapunov.exponents > len(model.states):
        keys = ("measures", "lyapunov", "exponents")
        raise place.error(keys, f"{model.name} has {len(model.states)} states", f"1 to {len(model.states)} exponents")
    return Sweep(config, model, grid, _clock(config, place), fixed, _broken_relations(model, fixed, grid))


def _check_names(config: Config, model: Model, place: _Place) -> None:
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


def _check_domains(model: Model, fixed: Mapping[str, float], grid: Grid, place: _Place) -> None:
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
        mesh = np.meshgrid(*(np.asarray(axis.values) for axis in axes), indexing="ij", sparse=True)
        values = {axis.name: part for axis, part in zip(axes, mesh, strict=True)}
        holds = np.asarray(relation.holds(**{name: values.get(name, fixed.get(name)) for name in relation.parameters}))
        if not holds.all():
            share = "" if holds.ndim == 0 else f" in {100 * (1 - holds.mean()):.3g} % of the cells"
            sentences.append(f"{relation.text} does not hold{share}; {relation.meaning}")
    return tuple(sentences)


def _clock(config: Config, place: _Place) -> Clock:
    """Round all times up to whole blocks, batches and segments."""
    section, lyapunov = config.integrate, config.measures.lyapunov
    block = lyapunov.block if lyapunov else 25
    total = section.transient + section.duration
    wanted = lyapunov.batch if lyapunov and lyapunov.batch else min(total / BATCHES, section.segment or total)
    batch_blocks = _whole(wanted, block * section.dt)
    batch = batch_blocks * block * section.dt
    segment_batches = _whole(section.segment, batch) if section.segment else BATCHES_PER_SEGMENT
    segment = segment_batches * batch
    transient = _whole(section.transient, segment) if section.transient else 0
    segments = transient + _whole(section.duration, segment)
    if segments > MAX_SEGMENTS or segments * segment / section.dt > 2**53:
        raise place.error(
            ("integrate", "duration"),
            f"{segments} looks and {segments * segment / section.dt:.3g} steps are too many",
            f"at most {MAX_SEGMENTS} segments; a longer segment or batch makes fewer",
        )
    return Clock(section.dt, block, batch_blocks, segment_batches, transient, segments)


def _whole(length: float, unit: float) -> int:
    """Return the number of units that cover a length; rounding errors do not add one."""
    return max(1, math.ceil(length / unit * (1 - 1e-12) - 1e-9))
