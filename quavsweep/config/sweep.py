"""Sweep: a config that has passed every check, with its model, grid and clock."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.clock import Clock
from quavsweep.config.schema import AxisSection, Config, IntegrateSection
from quavsweep.errors import ConfigError
from quavsweep.grid import Grid
from quavsweep.kernels.method import METHODS, ButcherTable
from quavsweep.measures import Dimension, Measures, Variable
from quavsweep.models import Model

READ = 1e-4  # of a segment, by which a time that is typed may differ from a look


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
    def folder(self) -> Path:
        """Where its run lies unless another folder is named."""
        return Path("results") / self.name

    @property
    def method(self) -> ButcherTable:
        """The Runge-Kutta table."""
        return METHODS[self.config.integrate.method]

    @property
    def measures(self) -> Measures:
        """What is recorded."""
        return self.config.measures

    @property
    def dense(self) -> bool:
        """Whether the state must be seen after every step: by a measure, or because it may leave the domain."""
        return self.measures.dense or self.model.limited

    @property
    def keeps_evidence(self) -> bool:
        """Whether shards hold the evidence of cells; if not, only what the classification makes of it."""
        return self.config.evidence == "full"

    def require_evidence(self, what: str, where: str = "") -> None:
        """Refuse what cannot be done without the evidence of cells.

        Raises
        ------
        ConfigError
            If shards do not hold it.
        """
        if not self.keeps_evidence:
            held = "this run has evidence: summary, so its shards hold only what goes into the result"
            raise ConfigError(f"{what} needs evidence: full; {held}", where, "another run with evidence: full can")

    @property
    def start_axes(self) -> tuple[str, ...]:
        """The axes along which initial states vary; the others are over parameters."""
        states = set(self.model.state_names)
        return tuple(axis.name for axis in self.grid.axes if states & set(axis.quantities))

    @property
    def points(self) -> Grid:
        """The grid of the parameter points, each of which has all starts."""
        return Grid(tuple(axis for axis in self.grid.axes if axis.name not in self.start_axes))

    @cached_property
    def starts(self) -> np.ndarray:
        """The initial states of a parameter point, (starts, D) float64, in the order of the axes over them."""
        grid = Grid(tuple(axis for axis in self.grid.axes if axis.name in self.start_axes))
        varied = grid.coordinates(0, grid.size)
        fixed = self.config.initial
        columns = [varied.get(name, np.full(grid.size, fixed.get(name))) for name in self.model.state_names]
        return np.stack(columns, axis=1).astype(np.float64)

    @cached_property
    def dimensions(self) -> dict[str, Dimension]:
        """The dimensions that evidence and result have beyond the cell."""
        return self.measures.dimensions(self.model, self.clock)

    @property
    def extents(self) -> dict[str, int]:
        """Their lengths."""
        return {name: len(dimension) for name, dimension in self.dimensions.items()}

    def unit(self, variable: Variable) -> str:
        """Return the unit of a variable, `1` for a pure number, empty where its components have different ones."""
        time = self.model.time_unit
        if variable.unit != "state":
            return {"time": time, "1/time": "1" if time == "1" else f"1/{time}"}.get(variable.unit, variable.unit)
        units = {
            unit for dim in variable.dims if dim in self.dimensions for unit in self.dimensions[dim].component_units
        }
        return units.pop() if len(units) == 1 else ""

    @property
    def unit_of_time(self) -> str:
        """Return the unit of time behind a number: ` s`, or nothing where time has no unit."""
        return "" if self.model.time_unit == "1" else f" {self.model.time_unit}"

    @property
    def cell_bytes(self) -> int:
        """Size of a cell's evidence."""
        shapes = ((v.dtype, v.shape(1, self.extents)) for v in self.measures.evidence)
        return sum(np.dtype(dtype).itemsize * math.prod(shape) for dtype, shape in shapes)

    def with_fixed(self, values: Mapping[str, float], grid: Grid) -> Sweep:
        """Return the sweep over another grid, with parameters and initial states fixed at these values."""
        names = self.model.parameter_names
        known = {**self.parameters, **values}
        parameters = {name: known[name] for name in names if name in known}
        initial = {**self.config.initial, **{n: v for n, v in values.items() if n not in names}}
        axes = {
            axis.name: self.config.axes[axis.name] if axis.along else AxisSection(values=list(axis.values))
            for axis in grid.axes
        }
        config = self.config.model_copy(update={"axes": axes, "initial": initial, "parameters": parameters})
        return replace(self, config=config, grid=grid, parameters=parameters)

    def until(self, steps: int) -> Sweep:
        """Return the sweep that ends after so many steps, a whole number of segments; canonical configs differ."""
        clock = replace(self.clock, segments=steps // self.clock.segment_steps)
        return replace(self, clock=clock)

    def without_effort(self) -> Sweep:
        """Return the sweep whose cells all end together."""
        return replace(self, config=self.config.model_copy(update={"effort": None}))

    def without_records(self) -> Sweep:
        """Return the sweep without the measures that no label rests on: what they recorded goes on beyond a horizon."""
        records = {name: None for name, measure in self.measures.chosen.items() if measure.outputs}
        measures = self.measures.model_copy(update=records)
        return replace(self, config=self.config.model_copy(update={"measures": measures}))

    def steps_at(self, horizon: float) -> int:
        """Return the steps of a horizon, a time from t = 0, whole segments beyond the transient.

        Times are taken as they are read: it may be off by 1e-4 of a segment.

        Raises
        ------
        ConfigError
            If nothing is stored there.
        """
        clock = self.clock
        length = clock.segment_steps * clock.dt
        first, last, segments = clock.transient_segments + 1, clock.segments, horizon / length
        ends = f"it may be {_digits(first * length)} to {_digits(last * length)} in steps of {_digits(length)}"
        if not math.isfinite(segments):
            raise ConfigError(f"a horizon of {horizon:g} is no time", possible=ends)
        whole = round(segments)
        if abs(segments - whole) <= READ and first <= whole <= last:
            return whole * clock.segment_steps
        low = min(max(math.floor(segments), first), last)
        near = sorted({low, min(max(math.ceil(segments), first), last)})
        what = f"nothing is stored at a horizon of {_digits(horizon)}{self.unit_of_time}"
        raise ConfigError(what, possible=f"nearest {' and '.join(_digits(n * length) for n in near)}; {ends}")

    @property
    def most_steps(self) -> int:
        """Steps to which cells of unknown end may be taken; those of the clock unless the config asks for effort."""
        clock, effort = self.clock, self.config.effort
        if effort is None:
            return clock.steps
        segments = math.ceil(effort.max_duration / (clock.segment_steps * clock.dt) - 1e-9)
        return max(clock.steps, (clock.transient_segments + segments) * clock.segment_steps)

    def pass_ends(self) -> Iterator[int]:
        """Yield the steps at which the passes of the effort end: each doubles the duration, up to the most."""
        clock, transient = self.clock, self.clock.transient_steps
        end = clock.steps
        while end < self.most_steps:
            end = min(transient + 2 * (end - transient), self.most_steps)
            yield end

    def settings(self) -> dict[str, Any]:
        """Return what of the canonical config may change a number or a label of the result."""
        data = {key: value for key, value in self.canonical().items() if key not in ("name", "plot")}
        return data | {"integrate": {k: v for k, v in data["integrate"].items() if k != "tolerance"}}

    def canonical(self) -> dict[str, Any]:
        """Return the config with every default and every rounded time written out; loading it gives the same sweep."""
        data = self.config.model_dump(mode="json", exclude_none=True)
        clock = self.clock
        if not self.config.plot:
            del data["plot"]
        for section in data.get("axes", {}).values():
            if "zip" in section:
                del section["spacing"]
        data["parameters"] = dict(self.parameters)
        data["initial"] = {name: data["initial"][name] for name in self.model.state_names if name in data["initial"]}
        times = data["integrate"] | {
            "transient": clock.transient,
            "duration": clock.duration,
            "segment": clock.segment_steps * clock.dt,
        }
        data["integrate"] = {key: times[key] for key in IntegrateSection.model_fields if key in times}
        return data


def _digits(time: float) -> str:
    """Return a time with so many digits that it is read as the same look."""
    return f"{time:.10g}"
