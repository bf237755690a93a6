"""YAML text: read without tags, aliases or surprises, with the place of every key; and written."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError

from quavsweep.config.composer import Composer
from quavsweep.config.place import Document, Keys, Spot
from quavsweep.config.syntax import events, syntax_error
from quavsweep.config.unprintable import decoded, printable

MAX_BYTES = 2**20


def read_document(text: str | bytes, start: Spot, root: Keys = ()) -> Document:
    """Return what a YAML text says; its keys stand under the keys of `root`.

    Raises
    ------
    ConfigError
        For what is not YAML 1.2, and for tags, anchors, aliases, merge and duplicate keys, and depth.
    """
    clean, unprintable = printable(decoded(text))
    composer = Composer(start, root, unprintable)
    try:
        for event in events(clean):
            composer.feed(event)
    except MarkedYAMLError as error:
        raise syntax_error(error, clean, composer) from error
    return composer.document


def read_config(text: str | bytes, where: str) -> Document:
    """Return what the YAML text of a config says; `where` names it in errors.

    Raises
    ------
    ConfigError
        See `read_document`; and if it is not a mapping of keys.
    """
    document = read_document(text, Spot(where, 1))
    if not isinstance(document.tree, dict):
        raise document.place.error((), "is not a mapping of keys", "a config is one")
    return document


def dump_config(data: Mapping[str, Any]) -> str:
    """Return a canonical config as YAML text."""
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 120
    yaml.dump(dict(data), stream)
    return stream.getvalue()
