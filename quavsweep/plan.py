"""Plan: all that integrating a tile needs, ready to run, and how cells begin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from quavsweep.analysis.cycle import CycleSearch
from quavsweep.clock import Clock
from quavsweep.config import Sweep
from quavsweep.grid import Tile
from quavsweep.kernels.compiler import make_advance
from quavsweep.kernels.described import require_equations
from quavsweep.kernels.layout import Layout
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.method import ButcherTable
from quavsweep.kernels.printer import step_operations
from quavsweep.kernels.program import Program
from quavsweep.kernels.step import choose_layout
from quavsweep.measures import Variable

OPERATION_NS = 0.033  # time of one operation of the step in one lane, from the cost of the printed kernels


@dataclass(frozen=True)
class Plan:
    """All that integrating a tile needs, ready to run.

    Parameters
    ----------
    sweep : Sweep
    program : Program
    layout : Layout
    advance : callable
        The compiled kernel; `record` where the state must be seen after every step.
    search : CycleSearch
        Finds and certifies cycles.
    """

    sweep: Sweep
    program: Program
    layout: Layout
    advance: Callable[..., None]
    search: CycleSearch

    @property
    def clock(self) -> Clock:
        """Lengths of time in steps."""
        return self.sweep.clock

    @property
    def method(self) -> ButcherTable:
        """The Runge-Kutta table."""
        return self.sweep.method

    @property
    def variables(self) -> tuple[Variable, ...]:
        """What the evidence holds."""
        return self.sweep.measures.evidence

    @cached_property
    def step_ns(self) -> float:
        """Estimated time of one step of one cell [ns], the same on every machine."""
        return OPERATION_NS * step_operations(self.program, self.method, self.layout)

    def until(self, steps: int) -> Plan:
        """Return the plan of the same cells, integrated to another end."""
        return replace(self, sweep=self.sweep.until(steps))

    @cached_property
    def late(self) -> tuple[Layout, Callable[..., None]]:
        """Layout and kernel of one tangent vector, for what is integrated beyond the end."""
        layout = choose_layout(self.program, self.method, 1, self.layout.lanes)
        return layout, make_advance(self.program, self.method, layout)


def make_plan(sweep: Sweep, lanes: int) -> Plan:
    """Return the plan of a sweep with a compiled kernel of so many lanes."""
    require_equations(sweep.model)
    program, measures = make_program(sweep.model), sweep.measures
    layout = choose_layout(program, sweep.method, measures.vectors, lanes, measures.trace)
    advance = make_advance(program, sweep.method, layout, sweep.dense)
    search = CycleSearch(sweep.model, program, sweep.method, sweep.clock, lanes)
    return Plan(sweep, program, layout, advance, search)


def cell_values(sweep: Sweep, cells: Tile | np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the parameters of cells, (n,) each in the model's order, and their initial states, (n, D)."""
    numbers = np.arange(cells.start, cells.stop) if isinstance(cells, Tile) else cells
    varied = sweep.grid.coordinates_of(numbers)
    fixed = {**sweep.parameters, **sweep.config.initial}
    value = {name: varied.get(name, np.full(len(numbers), fixed.get(name))) for name in (*fixed, *varied)}
    parameters = [np.asarray(value[name], dtype=np.float64) for name in sweep.model.parameter_names]
    return parameters, np.stack([value[name] for name in sweep.model.state_names], axis=1).astype(np.float64)
