"""Sweep: a config that has passed every check, with its model, grid and clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from quavsweep.clock import Clock
from quavsweep.config.schema import Config
from quavsweep.grid import Grid
from quavsweep.kernels.method import METHODS, ButcherTable
from quavsweep.measures import Measures
from quavsweep.models import Model


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
            "eigenvalue": len(self.model.states),
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
