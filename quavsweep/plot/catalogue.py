"""What a figure can show of a result, found by a name such as `final_state.p` or `lyapunov.2`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from quavsweep.codes import Region, Status
from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest
from quavsweep.plot.code import codes_of
from quavsweep.plot.quantity import Quantity
from quavsweep.plot.style import symbol, wrapped

if TYPE_CHECKING:
    from quavsweep.result import Result

# What a reader should see instead of a variable's name; of `{of}`, the state or number of a component.
TEXTS = {
    "lyapunov": r"$\lambda_{of}$",
    "lyapunov_raw": r"$\lambda_{of}$, averaged",
    "lyapunov_se": r"standard error of $\lambda_{of}$",
    "eigenvalue_re": r"$\mathrm{{Re}}\,\mu_{of}$",
    "eigenvalue_im": r"$\mathrm{{Im}}\,\mu_{of}$",
    "final_state": "final {of}",
    "equilibrium": "{of} at the equilibrium",
    "peak": "peak {of}",
    "peak_time": "time of the peak {of}",
    "settle_time": "settling time",
    "time_used": "time integrated",
    "sample_count": "number of samples",
    "sample_time": "time of sample {of}",
    "samples": "samples of {of}",
}
# Variables whose sign tells growth from decay.
RATES = ("lyapunov", "lyapunov_raw", "eigenvalue_re")
SAMPLE = "sample"  # the dimension of samples
FIRST = ("region", "status", "was_chaotic", "lyapunov")
MANY = 6  # more components than these are listed by the first and the last


@dataclass(frozen=True)
class Catalogue:
    """The quantities of a result.

    Parameters
    ----------
    result : Result
    samples : bool
        Whether they are drawn along a line: the samples of a cell together, so that their dimension does not count
        components, and numbers with their errors.
    """

    result: Result
    samples: bool = False

    @property
    def names(self) -> list[str]:
        """The variables that can be drawn."""
        variables = self.result.stored.dims
        first = [name for name in FIRST if name in variables]
        return [*first, *(name for name in variables if name not in first and self._fits(name))]

    def find(self, name: str) -> Quantity:
        """Return what a name stands for; the first component of a variable if it names none.

        Raises
        ------
        ConfigError
            If it stands for nothing that can be drawn.
        """
        variable, dot, key = name.partition(".")
        keys = self._keys(variable) if variable in self.names else []
        if variable not in self.names or (dot and key not in keys):
            raise self._unknown(name)
        return self._component(variable, keys.index(key) if dot else 0)

    def parts(self, name: str) -> list[Quantity]:
        """Return all components of a variable, or the one that is named.

        Raises
        ------
        ConfigError
            If the name stands for nothing that can be drawn.
        """
        first = self.find(name)
        if "." in name:
            return [first]
        return [self._component(name, i) for i in range(max(1, len(self._keys(name))))]

    def group_text(self, quantities: list[Quantity]) -> str:
        """Return what several components of a variable are together."""
        variable = quantities[0].name.partition(".")[0]
        if len(quantities) == 1 or variable not in TEXTS:
            return quantities[0].text
        return TEXTS[variable].format(of="k" if "_{of}" in TEXTS[variable] else "state")

    def _own_dims(self, variable: str) -> tuple[str, ...]:
        """Return the dimensions of a variable that count its components."""
        own = self.result.stored.dims[variable][len(self.result.sweep.grid.axes) :]
        return tuple(dim for dim in own if not (self.samples and dim == SAMPLE))

    def _fits(self, variable: str) -> bool:
        dims, axes = self.result.stored.dims[variable], tuple(axis.name for axis in self.result.sweep.grid.axes)
        return variable not in dims and dims[: len(axes)] == axes and len(self._own_dims(variable)) <= 1

    def _keys(self, variable: str) -> list[str]:
        """Return the names of a variable's components, none if it has only one number."""
        return [str(value) for dim in self._own_dims(variable) for value in self.result[dim]]

    def _unknown(self, name: str) -> ConfigError:
        keys = {variable: self._keys(variable) for variable in self.names}
        every = [*keys, *(f"{variable}.{key}" for variable, of in keys.items() for key in of)]
        listed = ", ".join(variable + _listed(of) for variable, of in keys.items())
        return ConfigError(f"no variable {name} to draw{nearest(name, every)}", possible=f"possible are {listed}")

    def _component(self, variable: str, index: int) -> Quantity:
        """Return one component of a variable."""
        result, keys = self.result, self._keys(variable)
        text, part = self._words(variable, keys[index] if keys else "")
        with_error = self.samples and variable == "lyapunov" and "lyapunov_se" in result
        return Quantity(
            name=f"{variable}.{keys[index]}" if keys else variable,
            values=self._values(variable, index) if keys else result[variable],
            text=text,
            unit=self._unit(variable, index),
            part=part,
            todo=result["status"] == Status.NOT_COMPUTED if variable == "status" else result["region"] == Region.NONE,
            codes=codes_of(result, variable),
            rate=variable in RATES,
            error=self._values("lyapunov_se", index) if with_error else None,
        )

    def _values(self, variable: str, index: int) -> np.ndarray:
        """Return the values of one component; the others are not read."""
        others = (slice(None),) * (len(self.result.stored.dims[variable]) - 1)
        return self.result.part(variable, (*others, index))

    def _words(self, variable: str, key: str) -> tuple[str, str]:
        """Return what a component is, and what it is called among the others."""
        model = self.result.sweep.model
        part = symbol(model, key) if key in model.state_names else key
        if variable == "first_time" and self.result.sweep.measures.first_time is not None:
            return self._first_time(), part
        if variable == "sample_time" and not key:
            return "time of the samples", part
        if variable in TEXTS:
            text = TEXTS[variable].format(of=f"{{{key}}}" if len(part) > 1 and part == key else part)
            return text, text if "_{of}" in TEXTS[variable] else part
        meaning = str(self.result.stored.attributes[variable].get("long_name", variable))
        return wrapped(meaning + (f", {key}" if key else "")), part

    def _first_time(self) -> str:
        """Return what the measure `first_time` waits for."""
        asked = self.result.sweep.measures.first_time
        assert asked is not None
        value, direction = asked.limit
        state = self.result.sweep.model.quantity(asked.of)
        return f"time until ${state.symbol or state.name} {'>' if direction == 'up' else '<'} {value:g}$"

    def _unit(self, variable: str, index: int) -> str:
        """Return the unit of a component, from the attributes of the result."""
        attributes = self.result.stored.attributes
        own = attributes[variable].get("units")
        listed = [attributes[dim].get("component_units", "") for dim in self._own_dims(variable)]
        units = ", ".join(listed).split(", ")
        return str(own or (units[index] if index < len(units) else "") or "1")


def _listed(keys: list[str]) -> str:
    """Return the components of a variable in brackets."""
    if len(keys) > MANY:
        return f" (.{keys[0]} to .{keys[-1]})"
    return f" (.{', .'.join(keys)})" if keys else ""
