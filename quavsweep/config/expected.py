"""What the schema accepts at a key, in words."""

from __future__ import annotations

import types
from itertools import zip_longest
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from quavsweep.config.place import Keys
from quavsweep.config.schema import ENSEMBLE, AnyAxis, AnyValues, AxisSection, Config, EnsembleSection, ValuesSection
from quavsweep.models import POSSIBLE

ONE = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}
MANY = {int: "whole numbers", float: "numbers", str: "words"}


def section_keys(keys: Keys) -> list[str]:
    """Return the keys that the schema has at a place."""
    kind, _ = _at(keys)
    sections = [part for part in map(_without_none, get_args(kind) or (kind,)) if _is_section(part)]
    return list(sections[0].model_fields) if len(sections) == 1 else []


def accepted(keys: Keys) -> str:
    """Return what may stand at a key, empty if the schema does not say: `a whole number from 1 to 1000000`."""
    if keys == ("model",):
        return POSSIBLE
    kind, info = _at(keys)
    return _words(kind, info.metadata if info else [])


def description(keys: Keys) -> str:
    """Return the schema's description of a key, empty if it has none."""
    _, info = _at(keys)
    return (info.description or "") if info and keys != ("model",) else ""


def kind_of(keys: Keys) -> Any:
    """Return the type of a key's value, None if the schema does not know the key."""
    return _at(keys)[0]


def _at(keys: Keys) -> tuple[Any, FieldInfo | None]:
    """Return type and description of what stands at a key."""
    kind: Any = Config
    info = None
    for key, following in zip_longest(keys, keys[1:]):
        if _is_section(kind) and key in kind.model_fields:
            info = kind.model_fields[str(key)]
            kind = _without_none(info.annotation)
        elif get_origin(kind) is dict or (get_origin(kind) is list and isinstance(key, int)):
            kind, info = _without_none(_member(get_args(kind)[-1], key, following)), None
        else:
            return None, None
    return kind, info


def _member(kind: Any, key: str | int, following: str | int | None) -> Any:
    """Return the kind of axis, or of values, that stands under a key, where there are several.

    What follows the key tells a list from a mapping; where nothing follows, both are possible.
    """
    if kind is AnyAxis:
        return EnsembleSection if key == ENSEMBLE else AxisSection
    if kind is AnyValues and following is not None:
        return list[float] if isinstance(following, int) else ValuesSection
    return kind


def _is_section(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _without_none(kind: Any) -> Any:
    """Return what an optional value is if it is there, without notes about it."""
    if get_origin(kind) is Annotated:
        return _without_none(get_args(kind)[0])
    if get_origin(kind) in (Union, types.UnionType):
        kinds = [part for part in get_args(kind) if part is not type(None)]
        return kinds[0] if len(kinds) == 1 else kind
    return kind


def _words(kind: Any, limits: list[Any]) -> str:
    """Return a type and its limits in words."""
    origin = get_origin(kind)
    if origin is Literal:
        return " or ".join(str(value) for value in get_args(kind))
    if origin is list:
        many = MANY.get(get_args(kind)[0], "mappings")
        return f"a list of {many}{_length(limits)}"
    if origin in (Union, types.UnionType):
        parts = (_words(_without_none(part), []) for part in get_args(kind) if part is not type(None))
        return ", or ".join(part for part in parts if part)
    if _is_section(kind):
        return f"a mapping with the keys {', '.join(kind.model_fields)}"
    if origin is dict:
        return "a mapping of keys"
    return f"{ONE[kind]}{_range(limits)}" if kind in ONE else ""


def _range(limits: list[Any]) -> str:
    """Return the range of a number: ` from 1 to 5`, ` above 0`."""
    words = {}
    for limit in limits:
        for name in ("ge", "gt", "le", "lt"):
            if hasattr(limit, name):
                words[name] = f"{getattr(limit, name)}"
    if "ge" in words and "le" in words:
        return f" from {words['ge']} to {words['le']}"
    prefixes = {"ge": "of at least", "gt": "above", "le": "of at most", "lt": "below"}
    return "".join(f" {prefix} {words[name]}" for name, prefix in prefixes.items() if name in words)


def _length(limits: list[Any]) -> str:
    """Return the length of a list: `, 1 to 1000 of them`."""
    least = max((limit.min_length for limit in limits if hasattr(limit, "min_length")), default=0)
    most = [limit.max_length for limit in limits if hasattr(limit, "max_length") and limit.max_length]
    if most:
        return f", {least} to {min(most)} of them"
    return f", at least {least}" if least else ""
