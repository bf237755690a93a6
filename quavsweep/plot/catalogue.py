"""What a figure can show of a result, found by a name such as `final_state.p` or `lyapunov.2`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from quavsweep.codes import REGION, Region, Status
from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest
from quavsweep.plot import observed
from quavsweep.plot.attractor import attractor_codes, attractor_values
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
    "statistic_mean": "mean {of}",
    "statistic_mean_se": "standard error of the mean {of}",
    "statistic_min": "least {of}",
    "statistic_max": "largest {of}",
    "sign_changes": "changes of sign of {of}",
    "peak_time": "time of the peak {of}",
    "settle_time": "settling time",
    "chaotic_until": "end of the chaos",
    "lyapunov_chaotic": r"$\lambda_1$ while chaotic",
    "lyapunov_chaotic_se": r"standard error of $\lambda_1$ while chaotic",
    "growth_departure": r"departure of the growth by $\lambda_{of}$",
    "sum_error": r"$\sum\lambda_k$ less the mean divergence",
    "zero_error": r"smallest $|\lambda_k|$ away from equilibria",
    "time_used": "time integrated",
    "last_time": "last time at the value",
    "sample_count": "number of samples",
    "sample_time": "time of sample {of}",
    "samples": "samples of {of}",
    "attractor": "attractor",
    "lifetime": "mean lifetime of chaos",
    "lifetime_se": "standard error of the lifetime",
    "lifetime_error": "error of the mean lifetime, relative",
    "lifetime_at_least": "mean lifetime of chaos, at least",
    "lifetime_after": "$t_0$",
    "lifetime_p": "$P$ of exponential leaving",
    "chaotic_share": "share chaotic beyond $t_0$",
    "basin_share": "share of starts: {of}",
    "attractor_share": "share of starts: attractor {of}",
}
LOGARITHMIC = ("lifetime", "lifetime_se", "lifetime_at_least")
SHARES = ("chaotic_share", "basin_share", "attractor_share")
BOUNDS = {"lifetime": "lifetime_at_least"}  # what is known where a number is not
RATIOS = {"lifetime_error": ("lifetime_se", "lifetime")}  # what is drawn and not stored
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
        ratios = [name for name, of in RATIOS.items() if set(of) <= set(variables) and self._fits(of[0])]
        return [*first, *(name for name in variables if name not in first and self._fits(name)), *ratios]

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
        every = [self._component(name, i) for i in range(max(1, len(self._stored_keys(name))))]
        return [quantity for quantity in every if not quantity.share or np.nan_to_num(quantity.shown).any()] or every[
            :1
        ]

    def group_text(self, quantities: list[Quantity]) -> str:
        """Return what several components of a variable are together."""
        variable = quantities[0].name.partition(".")[0]
        if len(quantities) == 1 or variable not in TEXTS:
            return quantities[0].text
        if quantities[0].share:
            return "share of starts"
        return TEXTS[variable].format(of="k" if "_{of}" in TEXTS[variable] else "state")

    def _own_dims(self, variable: str) -> tuple[str, ...]:
        """Return the dimensions of a variable that count its components."""
        variable = RATIOS.get(variable, (variable,))[0]
        own = self.result.stored.dims[variable][len(self.result.sweep.grid.axes) :]
        return tuple(dim for dim in own if not (self.samples and dim == SAMPLE))

    def _fits(self, variable: str) -> bool:
        dims, axes = self.result.stored.dims[variable], tuple(axis.name for axis in self.result.sweep.grid.axes)
        if variable in self.result.sweep.grid.quantities:
            return False
        return variable not in dims and dims[: len(axes)] == axes and len(self._own_dims(variable)) <= 1

    def _stored_keys(self, variable: str) -> list[str]:
        """Return the names of a variable's components, none if it has only one number."""
        return [str(value) for dim in self._own_dims(variable) for value in self.result[dim]]

    def _keys(self, variable: str) -> list[str]:
        """Return the names of its components, and of the observables that can be computed from them."""
        observables = self.result.sweep.model.observable_names if variable in observed.VARIABLES else ()
        return [*self._stored_keys(variable), *observables]

    def _unknown(self, name: str) -> ConfigError:
        keys = {variable: self._keys(variable) for variable in self.names}
        every = [*keys, *(f"{variable}.{key}" for variable, of in keys.items() for key in of)]
        listed = ", ".join(variable + _listed(self._stored_keys(variable)) for variable in keys)
        if observables := self.result.sweep.model.observable_names:
            listed += f"; of states also {', '.join(f'.{o}' for o in observables)}"
        return ConfigError(f"no variable {name} to draw{nearest(name, every)}", possible=f"possible are {listed}")

    def _component(self, variable: str, index: int) -> Quantity:
        """Return one component of a variable."""
        result, keys = self.result, self._keys(variable)
        text, part = self._words(variable, keys[index] if keys else "")
        error = f"{variable}_se"
        with_error = self.samples and error in result
        todo = result["starts"] == 0 if "region" not in result else result["region"] == Region.NONE
        return Quantity(
            name=f"{variable}.{keys[index]}" if keys else variable,
            values=self._values(variable, index) if keys else self._whole(variable),
            text=text,
            unit=self._unit(variable, index),
            part=part,
            todo=result["status"] == Status.NOT_COMPUTED if variable == "status" else todo,
            codes=attractor_codes(result) if variable == "attractor" else codes_of(result, variable),
            rate=variable in RATES,
            error=(self._values(error, index) if keys else result[error]) if with_error else None,
            bound=self._bound(variable),
            log=variable in LOGARITHMIC,
            share=variable in SHARES,
        )

    def _whole(self, variable: str) -> np.ndarray:
        """Return the values of a variable that has no components."""
        if variable == "attractor":
            return attractor_values(self.result)
        if variable in RATIOS:
            over, under = (self.result[name] for name in RATIOS[variable])
            return np.asarray(over / under)
        return self.result[variable]

    def _bound(self, variable: str) -> np.ndarray | None:
        """Return what a number exceeds where it is not known."""
        result = self.result
        if variable not in BOUNDS or BOUNDS[variable] not in result:
            return None
        return np.where(np.isnan(result[variable]), result[BOUNDS[variable]], np.nan)

    def _values(self, variable: str, index: int) -> np.ndarray:
        """Return the values of one component; the others are not read unless it is computed from them."""
        if index >= len(stored := self._stored_keys(variable)) > 0:
            name = self.result.sweep.model.observable_names[index - len(stored)]
            return observed.observed(self.result, variable, name)
        others = (slice(None),) * (len(self.result.stored.dims[variable]) - 1)
        return self.result.part(variable, (*others, index))

    def _words(self, variable: str, key: str) -> tuple[str, str]:
        """Return what a component is, and what it is called among the others."""
        model = self.result.sweep.model
        part = symbol(model, key) if key in (*model.state_names, *model.observable_names) else key
        if variable == "basin_share":
            part = next((code.meaning for code in REGION if code.name == key), key)
            return TEXTS[variable].format(of=part), part
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
        if variable in RATIOS:
            return "1"
        attributes = self.result.stored.attributes
        if index >= len(keys := self._stored_keys(variable)) > 0:
            return self.result.sweep.model.observables[index - len(keys)].unit
        own = attributes[variable].get("units")
        listed = [attributes[dim].get("component_units", "") for dim in self._own_dims(variable)]
        units = ", ".join(listed).split(", ")
        return str(own or (units[index] if index < len(units) else "") or "1")


def _listed(keys: list[str]) -> str:
    """Return the components of a variable in brackets."""
    if len(keys) > MANY:
        return f" (.{keys[0]} to .{keys[-1]})"
    return f" (.{', .'.join(keys)})" if keys else ""
