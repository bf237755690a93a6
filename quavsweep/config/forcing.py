"""The forcing of a sweep: one period for the whole grid, and a step of which it has a whole number."""

from __future__ import annotations

import math
from collections.abc import Mapping

from quavsweep.config.place import Keys, Place
from quavsweep.config.schema import Config
from quavsweep.config.times import DT, MAX_STEPS, whole
from quavsweep.grid import Grid
from quavsweep.models import Model
from quavsweep.models.mistake import mistake


def forcing_period(model: Model, fixed: Mapping[str, float], grid: Grid, place: Place) -> float:
    """Return the period of the forcing, 0 if there is none.

    Raises
    ------
    ConfigError
        If it differs from cell to cell, or is not a length of time.
    ModelError
        If the model's function for it fails.
    """
    if model.forcing_period is None:
        return 0.0
    values = {**fixed, **{axis.name: axis.values[0] for axis in grid.axes}}
    for axis in grid.axes:
        if axis.name in model.forcing_arguments and len(axis) > 1:
            what = f"{axis.name} changes the period of the forcing, so no step fits into it in all cells"
            possible = "give it one value; or let the forcing's phase be a state on a circle, whose rate is a parameter"
            raise place.error(("axes", axis.name), what, possible)
    try:
        period = float(model.forcing(values))
    except Exception as error:  # whatever a user's function may raise
        raise mistake(error, model.forcing_period) from error
    if not 0 < period < math.inf:
        name = next(iter(model.forcing_arguments), "")
        keys: Keys = next((k for k in (("parameters", name), ("axes", name)) if place.has(k)), ("model",))
        raise place.error(keys, f"makes the period of the forcing {period:g}", "a finite length above 0")
    return period


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
