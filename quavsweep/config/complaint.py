"""What a schema finds wrong, in words: the error that comes first in the text, with its key and what is possible."""

from __future__ import annotations

import difflib
import types
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from quavsweep.config.document import Place
from quavsweep.config.schema import Config
from quavsweep.errors import ConfigError
from quavsweep.models import NAMES


def first_error(error: ValidationError, place: Place) -> ConfigError:
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
        elif item["type"] == "string_pattern_mismatch":
            what, possible = f"{item['input']!r} is not accepted", f"it may have {_describe(keys)}"
        elif item["type"] in ("dict_type", "model_type"):
            what = "is not a mapping of keys"
            possible = f"possible keys are {', '.join(_section(keys))}" if _section(keys) else ""
        elif item["type"] == "value_error":
            what, possible = str(item["ctx"]["error"]), ""
        else:
            message = item["msg"].removeprefix("Input should be ").removeprefix("a valid ")
            given = _shown(item["input"])
            what = f"{given if len(given) < 40 else given[:37] + '...'} is not accepted"
            possible = f"it should be {message}" if message != item["msg"] else item["msg"]
        # A misspelt key makes another one missing; the misspelt one is what the user has to see.
        found.append((item["type"] == "missing", place.line(keys), keys, what, possible))
    *_, keys, what, possible = min(found, key=lambda row: row[:2])
    return place.error(keys, what, possible)


def _shown(value: Any) -> str:
    """Return a value as text; integers may be too long for that."""
    try:
        return repr(value)
    except ValueError:
        return "a number of thousands of digits"


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
    if keys == ("model",):
        return f"the catalogue has {', '.join(NAMES)}"
    kind: Any = Config
    for key in keys[:-1]:
        kind = _model_of(kind.model_fields[key].annotation)
    return kind.model_fields[keys[-1]].description or f"it has the keys {', '.join(_section(keys))}"
