"""Zipped axes: several quantities that vary together along a curve, and what they must fulfil."""

from __future__ import annotations

import re

from quavsweep.config.place import Keys, Place
from quavsweep.config.schema import ENSEMBLE, AxisSection, Config, ValuesSection
from quavsweep.grid import Axis
from quavsweep.models import Model
from quavsweep.models.model import NAME, RESERVED

AXES: Keys = ("axes",)
ZIP = "give [a list] or {start, stop, num} for each of some parameters or states"


def make_zipped(name: str, section: AxisSection) -> Axis:
    """Return the axis of a curve: its values count the points, 0, 1, ..., and what varies lies along it."""
    along = tuple((quantity, part.points()) for quantity, part in section.zipped.items())
    return Axis(name, tuple(range(section.length)), along)


def is_zipped(keys: Keys) -> bool:
    """Whether these are the keys of a quantity that varies together with others."""
    return keys[2:3] == ("zip",)


def is_list(keys: Keys, config: Config) -> bool:
    """Whether a list stands there, and no mapping."""
    return is_zipped(keys) and isinstance((config.zipped[str(keys[1])].zip or {})[str(keys[3])], list)


def given_values(config: Config) -> dict[Keys, ValuesSection]:
    """Return what the config says of the values of each quantity, by the key where it does."""
    given: dict[Keys, ValuesSection] = {}
    for name, section in config.axes.items():
        if isinstance(section, AxisSection):
            along = section.zipped
            given |= {(*AXES, name, "zip", q): part for q, part in along.items()} if along else {(*AXES, name): section}
    return given


def check_names(config: Config, model: Model, place: Place) -> None:
    """Refuse a curve whose name something else has, and a quantity that varies along two axes.

    Raises
    ------
    ConfigError
        For the first of them.
    """
    known = (*model.parameter_names, *model.state_names)
    varied: dict[str, Keys] = {name: (*AXES, name) for name in config.axes if name not in (ENSEMBLE, *config.zipped)}
    varied |= {name: (*AXES, ENSEMBLE, "box", name) for name in (config.ensemble.box if config.ensemble else ())}
    for name, section in config.zipped.items():
        keys: Keys = (*AXES, name)
        if name in known:
            what = f"is a quantity of {model.name}, and so no name of what several vary along"
            raise place.error(keys, what, f"a name of its own, such as curve; {name} may be one of those in zip")
        if name in RESERVED or not re.fullmatch(NAME, name):
            raise place.error(keys, "cannot be the name of an axis", "letters, digits, _; no name of the results' own")
        if not section.zip:
            raise place.error((*keys, "zip"), "is empty", ZIP)
        for quantity in section.zip:
            here, there = (*keys, "zip", quantity), varied.get(quantity)
            if there is not None:
                raise place.error(here, f"is varied in {place.other(there, here)} already", "keep one of the two")
            varied[quantity] = here


def check_zipped(config: Config, place: Place) -> None:
    """Refuse other keys beside `zip`, and quantities of which there are not equally many values.

    Raises
    ------
    ConfigError
        For the first of them.
    """
    for name, section in config.zipped.items():
        keys: Keys = (*AXES, name, "zip")
        for key in ValuesSection.model_fields:
            if getattr(section, key) not in (None, "linear"):
                beside = (*AXES, name, key)
                raise place.error(beside, f"cannot stand beside {place.other(keys, beside)}", "keep one of the two")
        (first, one), *others = section.zipped.items()
        for other, part in others:
            if part.length != one.length:
                here = (*keys, other)
                what = f"has {part.length} values, {place.other((*keys, first), here)} has {one.length}"
                raise place.error(here, what, "equally many of each")
