"""Why a text is not YAML, from what was wrong already with what could be read of it.

A bracket that closes too early or too late, or a wrong indentation, puts keys where they do not belong, often long
before the parser gives up.
"""

from __future__ import annotations

from pydantic import ValidationError

from quavsweep.config.complaint import NO_MAPPING, UNKNOWN, Complaint, complaints
from quavsweep.config.place import Document, Keys, dotted
from quavsweep.config.schema import Config
from quavsweep.config.syntax import Brackets, UnreadableError
from quavsweep.errors import ConfigError


def explained(error: UnreadableError) -> ConfigError:
    """Return the error of a text that is not YAML, with what may be the reason."""
    document, place = error.document, error.document.place
    wrong = _first_wrong(document)
    if wrong is None or (error.brackets is Brackets.FINE and wrong.keys == error.keys):
        return error
    if error.brackets is Brackets.FINE:
        suspects = [keys for keys in (document.before(wrong.keys), wrong.keys) if keys not in ((), error.keys)]
        named = " or ".join(place.other(keys, error.keys) for keys in suspects)
        return ConfigError(error.what, error.where, f"the cause may be {named}; {dotted(wrong.keys)}: {wrong.what}")
    keys, what = _to_blame(wrong, error)
    if keys == error.keys and what == wrong.what:
        return error
    return place.error(keys, what, f"this may be why {error}")


def _first_wrong(document: Document) -> Complaint | None:
    """Return what is wrong with a text of which only the beginning was read, if anything is."""
    last = next(reversed(document.spots), ())
    unread = () if document.words.get(last) else last
    try:
        Config.model_validate(document.tree)
    except ValidationError as error:
        found = complaints(error, document, late=False)
        return next((c for c in found if c.keys and (c.keys != unread or c.kind == UNKNOWN)), None)
    return None


def _to_blame(wrong: Complaint, error: UnreadableError) -> tuple[Keys, str]:
    """Return the key whose brackets are wrong, and why."""
    closed = error.brackets is Brackets.CLOSED_EARLY
    displaced = _displaced(wrong, closed)
    if displaced is None:
        return wrong.keys, wrong.what
    place, before = error.document.place, error.document.before(displaced)
    if closed or len(displaced) == 1:
        return before, f"{place.other(displaced, before)} after it does not belong there"
    section = displaced[:-1]
    last = place.other(before[: len(displaced)], section)
    return section, f"holds {place.other(displaced, section)}, which does not belong there, after {last}"


def _displaced(wrong: Complaint, closed: bool) -> Keys | None:
    """Return the key that is not where it belongs: a section inside another one, an unknown key."""
    sections = (n for n in range(1, len(wrong.keys)) if wrong.keys[n] in Config.model_fields)
    if (n := next(sections, None)) is not None:
        return wrong.keys[: n + 1]
    return wrong.keys if wrong.kind == UNKNOWN or (closed and wrong.kind in NO_MAPPING) else None
