"""Overrides of the command line, `--set KEY=VALUE`: put into a config before the schema sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from quavsweep.config.composer import MAX_DEPTH
from quavsweep.config.document import MAX_BYTES, read_document
from quavsweep.config.place import Document, Keys, Spot, escaped
from quavsweep.errors import ConfigError

POSSIBLE = "KEY=VALUE, e.g. axes.c.num=101; KEY= removes the key"


def apply_changes(document: Document, changes: Sequence[str]) -> None:
    """Put overrides into the tree of a document, one after the other.

    Raises
    ------
    ConfigError
        For a text that is no override, a value that cannot be read, and a key that cannot be set or removed.
    """
    for change in changes:
        key, sign, value = change.partition("=")
        spot = Spot(f"--set {escaped(change)}")
        keys = tuple(part.strip() for part in key.split("."))
        if not sign or not all(keys) or len(keys) > MAX_DEPTH:
            raise ConfigError("is not an override", str(spot), POSSIBLE)
        if len(value) > MAX_BYTES:
            raise ConfigError(f"is larger than {MAX_BYTES} bytes", str(spot), POSSIBLE)
        if value.strip():
            _put(document, keys, read_document(value, spot, keys))
        else:
            _remove(document, keys, spot)


def _put(document: Document, keys: Keys, value: Document) -> None:
    """Put a value under a key; sections on the way are made, and what was there before is forgotten."""
    section = _section(document, keys, value.start)
    _forget(document, keys)
    section[keys[-1]] = value.tree
    document.spots[keys] = value.start
    document.spots |= value.spots
    document.words |= value.words


def _remove(document: Document, keys: Keys, spot: Spot) -> None:
    """Remove a key that is there."""
    section = _section(document, keys, spot, make=False)
    if keys[-1] not in section:
        there = f"there is {', '.join(map(str, section))}" if section else "nothing is there"
        document.spots[keys] = spot
        raise document.place.error(keys, "cannot be removed, it is not there", escaped(there))
    _forget(document, keys)
    del section[keys[-1]]
    document.spots[keys] = spot


def _section(document: Document, keys: Keys, spot: Spot, make: bool = True) -> dict[Any, Any]:
    """Return the mapping that holds the last of these keys; sections on the way are made if asked for."""
    node = document.tree
    for n, key in enumerate(keys[:-1], 1):
        inner = node.get(key)
        if inner is None and make:
            inner = node[key] = {}
            document.spots[keys[:n]] = spot
            document.words.pop(keys[:n], None)
        node = {} if inner is None else inner
        if not isinstance(node, dict):
            document.spots[keys] = spot
            kind = "a list" if isinstance(node, list) else "a value"
            raise document.place.error(keys, f"{document.place.other(keys[:n], keys)} is {kind} and has no keys")
    assert isinstance(node, dict)
    return node


def _forget(document: Document, keys: Keys) -> None:
    """Forget the places and words of a key and of all that is under it."""
    for table in (document.spots, document.words):
        for known in [known for known in table if known[: len(keys)] == keys]:
            del table[known]
