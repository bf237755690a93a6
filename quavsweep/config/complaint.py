"""What a schema finds wrong, in words: the error that comes first in the text, with its key and what is possible."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from quavsweep.config.expected import accepted, description, kind_of, section_keys
from quavsweep.config.place import Document, Keys, dotted, escaped, quoted
from quavsweep.config.schema import Config
from quavsweep.config.syntax import UnreadableError
from quavsweep.errors import ConfigError


@dataclass(frozen=True)
class Complaint:
    """One thing that is wrong: the key, what, what is possible, and whether it is only a key that is missing."""

    keys: Keys
    what: str
    possible: str = ""
    absence: bool = False


def first_error(error: ValidationError, document: Document) -> ConfigError:
    """Return the error that comes first in the text, in words."""
    first = _complaints(error, document)[0]
    return document.place.error(first.keys, first.what, first.possible)


def explained(error: UnreadableError) -> ConfigError:
    """Return the error of a text that is not YAML, with what is wrong already with what was read of it.

    A bracket that is closed too early or too late puts keys where they do not belong.
    """
    document = error.document
    if not isinstance(document.tree, dict):
        return error
    last = next(reversed(document.spots), ())
    unread = () if document.words.get(last) else last
    try:
        Config.model_validate(document.tree)
    except ValidationError as invalid:
        found = [c for c in _complaints(invalid, document) if c.keys != unread and not c.absence]
    else:
        found = []
    if not found:
        return error
    wrong = found[0]
    suspects = [document.before(wrong.keys), *(c.keys for c in found[:2])]
    suspects = [keys for keys in dict.fromkeys(suspects) if keys and keys != error.keys]
    named = " or ".join(document.place.other(keys, error.keys) for keys in suspects)
    return ConfigError(error.what, error.where, f"the cause may be {named}; {dotted(wrong.keys)}: {wrong.what}")


def _complaints(error: ValidationError, document: Document) -> list[Complaint]:
    """Return all that is wrong, in the order of the text.

    A misspelt key makes another one missing, which comes last: the misspelt one is what the user has to see.
    """
    order = {keys: i for i, keys in enumerate(document.spots)}
    found = [_complaint(item, document) for item in error.errors(include_url=False)]
    return sorted(found, key=lambda c: (c.absence, max(order.get(c.keys[:n], 0) for n in range(len(c.keys) + 1))))


def _complaint(item: Any, document: Document) -> Complaint:
    """Return an error of pydantic in words."""
    keys = tuple(key for key in item["loc"] if key != "[key]")
    comma = _decimal_comma(keys, item, document)
    return comma or WORDS.get(item["type"], _not_accepted)(keys, item, document)


def _decimal_comma(keys: Keys, item: Any, document: Document) -> Complaint | None:
    """Return the complaint about `{duration: 400,5}`, which YAML reads as a duration of 400 and an empty key 5."""
    before = document.before(keys)
    is_number = keys and item["input"] is None and str(keys[-1]).isdecimal()
    if not is_number or before[:-1] != keys[:-1] or kind_of(before) not in (int, float):
        return None
    what = f"{document.words.get(before)},{keys[-1]} is not accepted"
    return Complaint(before, what, _possible(before, "decimals are written with a point"))


def _unknown(keys: Keys, item: Any, document: Document) -> Complaint:
    possible = section_keys(keys[:-1])
    near = difflib.get_close_matches(str(keys[-1]), possible, 1)
    hint = f", did you mean {near[0]}?" if near else ""
    return Complaint(keys, f"unknown key{hint}", f"possible keys are {', '.join(possible)}")


def _missing(keys: Keys, item: Any, document: Document) -> Complaint:
    return Complaint(keys, "is missing", _possible(keys), absence=True)


def _no_mapping(keys: Keys, item: Any, document: Document) -> Complaint:
    possible = section_keys(keys)
    return Complaint(keys, "is not a mapping of keys", f"possible keys are {', '.join(possible)}" if possible else "")


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
    "extra_forbidden": _unknown,
    "missing": _missing,
    "dict_type": _no_mapping,
    "model_type": _no_mapping,
    "model_attributes_type": _no_mapping,
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
