"""What a schema finds wrong, in words: the error that comes first in the text, with its key and what is possible."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from pydantic import ValidationError

from quavsweep.config.expected import accepted, description, kind_of, section_keys
from quavsweep.config.place import Document, Keys, escaped, quoted
from quavsweep.config.schema import TAGS
from quavsweep.errors import ConfigError
from quavsweep.nearest import nearest

UNKNOWN = "extra_forbidden"
NO_MAPPING = frozenset(["dict_type", "model_type", "model_attributes_type"])


@dataclass(frozen=True)
class Complaint:
    """One thing that is wrong: the key, what, what is possible, and pydantic's type of the error."""

    keys: Keys
    what: str
    possible: str = ""
    kind: str = ""


def first_error(error: ValidationError, document: Document) -> ConfigError:
    """Return the error that comes first in the text, in words."""
    first = next(complaints(error, document))
    return document.place.error(first.keys, first.what, first.possible)


def complaints(error: ValidationError, document: Document, late: bool = True) -> Iterator[Complaint]:
    """Yield what is wrong, in the order of the text; last, or not at all, what another mistake may be the reason of."""
    order = {keys: i for i, keys in enumerate(document.spots)}

    def rank(item: Any) -> tuple[bool, int, bool]:
        comma = _decimal_comma(_keys(item), item, document)
        keys = comma.keys if comma else _keys(item)
        return _is_late(item), max(order.get(keys[:n], 0) for n in range(len(keys) + 1)), not comma

    for item in sorted(error.errors(include_url=False), key=rank):
        if late or not _is_late(item):
            yield _complaint(item, document)


def _is_late(item: Any) -> bool:
    """Whether another mistake may be the reason.

    A misspelt key makes another one missing; the keys of a section that is empty may be indented wrongly.
    """
    return item["type"] in ("missing", "value_error") or (item["type"] in NO_MAPPING and item["input"] is None)


def _keys(item: Any) -> Keys:
    return tuple(key for key in item["loc"] if key not in ("[key]", *TAGS))


def _complaint(item: Any, document: Document) -> Complaint:
    """Return an error of pydantic in words."""
    found = _decimal_comma(_keys(item), item, document)
    found = found or WORDS.get(item["type"], _not_accepted)(_keys(item), item, document)
    return replace(found, kind=item["type"])


def _decimal_comma(keys: Keys, item: Any, document: Document) -> Complaint | None:
    """Return the complaint about `{duration: 400,5}`, which YAML reads as a duration of 400 and an empty key 5."""
    if item["input"] is not None or not keys or not isinstance(keys[-1], str) or not keys[-1].isdecimal():
        return None
    before = document.before(keys)
    if before[:-1] != keys[:-1] or kind_of(before) not in (int, float):
        return None
    what = f"{document.words.get(before)},{keys[-1]} is not accepted"
    return Complaint(before, what, _possible(before, "decimals are written with a point"))


def _unknown(keys: Keys, item: Any, document: Document) -> Complaint:
    possible = section_keys(keys[:-1])
    return Complaint(keys, f"unknown key{nearest(str(keys[-1]), possible)}", f"possible keys are {', '.join(possible)}")


def _missing(keys: Keys, item: Any, document: Document) -> Complaint:
    return Complaint(keys, "is missing", _possible(keys))


def _no_mapping(keys: Keys, item: Any, document: Document) -> Complaint:
    possible = section_keys(keys)
    if ", or " in accepted(keys):  # a mapping is but one of what may stand here
        return _not_accepted(keys, item, document)
    colon = isinstance(item["input"], str) and ":" in item["input"]
    what = f", {quoted(item['input'])} has no blank after the colon" if colon else ""
    keys_of_it = f"possible keys are {', '.join(possible)}" if possible else ""
    return Complaint(keys, f"is not a mapping of keys{what}", keys_of_it)


def _relation(keys: Keys, item: Any, document: Document) -> Complaint:
    """Return what a validator says of a section, with the keys that it speaks of."""
    sentence, place = str(item["ctx"]["error"]), document.place
    spoken = [(*keys, key) for key in section_keys(keys) if len(key) > 2 and re.search(rf"\b{key}\b", sentence)]
    first = next((key for key in spoken if place.has(key)), keys)
    others = ", ".join(place.other(key, first) for key in spoken if key != first)
    return Complaint(first, sentence, f"see {others}" if others else "")


def _pattern(keys: Keys, item: Any, document: Document) -> Complaint:
    return Complaint(keys, f"{quoted(item['input'])} is not accepted", f"it may have {description(keys)}")


def _not_accepted(keys: Keys, item: Any, document: Document) -> Complaint:
    """Return the complaint about a value of the wrong type or outside its range."""
    value, word = item["input"], document.words.get(keys)
    possible = _possible(keys, _hint(kind_of(keys), value, word)) or item["msg"]
    return Complaint(keys, f"{_shown(value, word)} is not accepted", possible)


def _possible(keys: Keys, hint: str = "") -> str:
    """Return what may stand at a key: `it should be a number above 0 (step)`."""
    expected = accepted(keys)
    notes = "; ".join(note for note in (description(keys), hint) if note)
    should = "" if keys == ("model",) or not expected else "it should be "
    return f"{should}{expected}{f' ({notes})' if notes else ''}".strip()


# Other types of pydantic's errors say what a value should be, and that is taken from the schema.
WORDS: dict[str, Callable[[Keys, Any, Document], Complaint]] = {
    **dict.fromkeys(NO_MAPPING, _no_mapping),
    UNKNOWN: _unknown,
    "missing": _missing,
    "value_error": _relation,
    "string_pattern_mismatch": _pattern,
}


def _shown(value: Any, word: str | None) -> str:
    """Return a value as the user wrote it, shortened."""
    if value is None:
        return "an empty value" if not word else f"the empty value {word}"
    if isinstance(value, dict | list):
        name = "a mapping" if isinstance(value, dict) else "a list"
        return name if value else f"an empty {name.split()[1]}"
    return quoted(value) if isinstance(value, str) else escaped(word or repr(value))


def _hint(kind: Any, value: Any, word: str | None) -> str:
    """Return what a user may not know about writing numbers."""
    if kind not in (int, float) or isinstance(value, bool | dict | list | None):
        return ""
    if not isinstance(value, str):
        return "" if kind is int or _is_finite(value) else "finite, at most 1.8e308"
    if kind is float and re.fullmatch(r"[-+\d]+,\d+", value):
        return "decimals are written with a point"
    if re.fullmatch(r"[-+.\deE_]+", value):
        return "numbers have no _" if "_" in value else "numbers have no quotes" * (word is None)
    return ""


def _is_finite(value: float) -> bool:
    """Whether a number fits into 64 bits."""
    try:
        return math.isfinite(float(value))
    except OverflowError:
        return False
