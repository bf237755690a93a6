"""A model that was read from its description: it can be looked at, and it cannot be integrated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from quavsweep.errors import ModelError
from quavsweep.kernels.program import Program
from quavsweep.models import Model


@dataclass(frozen=True)
class DescribedModel(Model):
    """A model that was read from its description: it has a program, but no equations to call."""

    program: Program | None = None
    observed: Program | None = None

    def _check_functions(self) -> None:
        program = self.program
        names = [[name[2:] for name in part] for part in (program.states, program.parameters)] if program else []
        if names != [[*self.state_names], [*self.parameter_names]]:
            raise ModelError("its program has other names than its states and parameters", self.name)

    @property
    def forcing_arguments(self) -> tuple[str, ...]:
        """Names of the parameters that the period of the forcing depends on."""
        program = self.program
        assert program is not None
        known = {program.period, *(ref for a in program.needed([program.period]) for ref in a.arguments)}
        return tuple(name for name in self.parameter_names if f"p_{name}" in known)

    def forcing(self, parameters: Mapping[str, Any]) -> Any:
        """Return the period of the forcing for parameters by name; None if the system is autonomous."""
        program = self.program
        assert program is not None
        if not program.forced:
            return None
        known = {f"p_{name}": np.float64(parameters[name]) for name in self.forcing_arguments}
        return program.evaluate([program.period], known)[0]


def require_equations(model: Model) -> None:
    """Refuse to integrate a model that is only described.

    Raises
    ------
    ModelError
        With what is needed.
    """
    if isinstance(model, DescribedModel):
        no_equations(name=model.name)


def no_equations(*_: Any, name: str = "this model") -> NoReturn:
    """Stand for the functions that a described model does not have."""
    what = f"the equations of {name} are needed for this, and they are in its author's file"
    raise ModelError(what, possible="name it with --model FILE, or load_sweep(..., model=FILE)")
