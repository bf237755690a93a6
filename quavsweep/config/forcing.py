"""The forcing of a sweep: one period for the whole grid, and a step of which it has a whole number."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from quavsweep.config.place import Keys, Place
from quavsweep.config.schema import Config
from quavsweep.config.times import DT, MAX_STEPS, whole
from quavsweep.errors import ModelError
from quavsweep.grid import Grid
from quavsweep.kernels.lookup import make_program
from quavsweep.kernels.program import Program
from quavsweep.models import Model
from quavsweep.models.mistake import mistake

TRIED = 16  # states and times at which the equations are tried
SAME = 1e-6  # difference after a period, against the largest derivative, that rounding may make


def forcing_period(model: Model, fixed: Mapping[str, float], grid: Grid, place: Place) -> float:
    """Return the period of the forcing, 0 if there is none.

    Raises
    ------
    ConfigError
        If it differs from cell to cell, or is not a length of time.
    ModelError
        If the model's function for it fails, or the equations do not have that period.
    """
    if model.forcing_period is None:
        return 0.0
    values = {**fixed, **{name: float(along[0]) for name, along in grid.coordinates(0, 1).items()}}
    for axis in grid.axes:
        for name in [n for n, v in axis.quantities.items() if n in model.forcing_arguments and len(set(v)) > 1]:
            what = f"{name} changes the period of the forcing, so no step fits into it in all cells"
            possible = "give it one value; or let the forcing's phase be a state on a circle, whose rate is a parameter"
            raise place.error(("axes", axis.name, *(("zip", name) if axis.along else ())), what, possible)
    try:
        period = float(model.forcing(values))
    except Exception as error:  # whatever a user's function may raise
        raise mistake(error, model.forcing_period) from error
    if not 0 < period < math.inf:
        name = next(iter(model.forcing_arguments), "")
        keys: Keys = next((k for k in (("parameters", name), ("axes", name)) if place.has(k)), ("model",))
        raise place.error(keys, f"makes the period of the forcing {period:g}", "a finite length above 0")
    if not _repeats(make_program(model), fixed, grid, period):
        what = f"the equations do not repeat themselves after the forcing_period, here {period:g}"
        raise ModelError(what, model.name, "only periodic forcing is known; a multiple of the period will do")
    return period


def _repeats(program: Program, fixed: Mapping[str, float], grid: Grid, period: float) -> bool:
    """Whether the derivatives are the same a period later: at some states and times, in cells all over the grid."""
    rng = np.random.default_rng(1)
    u, t = rng.uniform(-1.0, 1.0, (program.dimension, TRIED)), rng.uniform(0.0, period, TRIED)
    varied = grid.coordinates_of(np.linspace(0, grid.size - 1, TRIED).round().astype(int))
    names = [name.removeprefix("p_") for name in program.parameters]
    coefficients = program.coefficient_values([varied.get(n, np.full(TRIED, fixed.get(n))) for n in names])
    with np.errstate(all="ignore"):
        now, later = (_derivatives(program, u, coefficients, time) for time in (t, t + period))
        return not (np.abs(later - now) > SAME * np.nanmax(np.abs(now))).any()


def _derivatives(program: Program, u: np.ndarray, coefficients: np.ndarray, t: np.ndarray) -> np.ndarray:
    return np.array(
        [value + np.zeros(TRIED) for value in program.evaluate(program.rhs, program.names(u, coefficients, t))]
    )


def in_step(config: Config, period: float, place: Place) -> tuple[Config, int]:
    """Return the config with a step of which the period has a whole number, and that number; 0 if nothing is forced.

    The step is shortened until the period has whole blocks, or the block whole periods: then batches can have whole
    numbers of both without being long.
    """
    if not period:
        return config, 0
    if not period / config.integrate.dt < MAX_STEPS:
        raise place.error(DT, f"{config.integrate.dt:g} goes more than 9e15 times into the period of the forcing")
    block = config.measures.block
    steps = whole(period, config.integrate.dt)
    if steps > block:
        steps = -(-steps // block) * block
    else:
        steps = next(divisor for divisor in range(steps, block + 1) if block % divisor == 0)
    integrate = config.integrate.model_copy(update={"dt": period / steps})
    return config.model_copy(update={"integrate": integrate}), steps


def shortened(asked: Config, used: Config, steps: int) -> tuple[str, ...]:
    """Return a sentence if the step had to be changed."""
    before, after = asked.integrate.dt, used.integrate.dt
    if not steps or math.isclose(before, after, rel_tol=1e-9):
        return ()
    return (f"integrate.dt {before:g} -> {after:.6g}, so that a period of the forcing has {steps} steps",)
