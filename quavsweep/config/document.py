"""YAML text: read without tags, aliases or surprises, with the line of every key; and written."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedBase
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent, DocumentStartEvent, ScalarEvent

from quavsweep.errors import ConfigError

MAX_BYTES = 2**20
MAX_DEPTH = 20


class Place:
    """Finds the line of a key in the text."""

    def __init__(self, where: str, tree: Any) -> None:
        self.where, self.tree = where, tree

    def line(self, keys: tuple[Any, ...]) -> int:
        """Return the line of the innermost of these keys that the text has, counted from 1."""
        node, line = self.tree, 1
        for key in keys:
            try:
                line = node.lc.data[key][0] + 1
                node = node[key]
            except (AttributeError, KeyError, IndexError, TypeError):
                break
        return int(line)

    def error(self, keys: tuple[Any, ...], what: str, possible: str = "") -> ConfigError:
        """Return the error that names file, line and key."""
        key = ".".join(str(k) for k in keys)
        where = f"{self.where}:{self.line(keys)}" + (f": {key}" if key else "")
        return ConfigError(what, where, possible)


def read_yaml(text: str | bytes, where: str) -> Any:
    """Return the tree of a YAML text with line numbers; tags, anchors, aliases and depth are refused before loading."""
    try:
        if isinstance(text, bytes):
            text = text.decode("utf-8")
        yaml = YAML(typ="rt", pure=True)
        depth = 0
        for event in yaml.parse(io.StringIO(text)):
            line = f"{where}:{event.start_mark.line + 1}"
            if isinstance(event, DocumentStartEvent) and event.version not in (None, (1, 2)):
                raise ConfigError("is not YAML 1.2", line)
            if isinstance(event, AliasEvent) or getattr(event, "anchor", None) is not None:
                raise ConfigError("anchors and aliases are not allowed", line)
            if isinstance(event, ScalarEvent | CollectionStartEvent) and event.tag is not None:
                raise ConfigError("tags are not allowed", line)
            depth += isinstance(event, CollectionStartEvent) - isinstance(event, CollectionEndEvent)
            if depth > MAX_DEPTH:
                raise ConfigError(f"nested deeper than {MAX_DEPTH}", line)
        tree = YAML(typ="rt", pure=True).load(text)
    except UnicodeDecodeError as error:
        raise ConfigError("is not UTF-8 text", where) from error
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark is not None else ""
        problem = " ".join((error.problem or "cannot be parsed").split())
        problem += "; use spaces" if "\\t" in problem else ""
        raise ConfigError(problem, f"{where}{line}") from error
    except (YAMLError, ValueError, RecursionError) as error:
        raise ConfigError("is not YAML: " + " ".join(str(error).split())[:120], where) from error
    if not isinstance(tree, dict):
        raise ConfigError("is not a mapping of keys", f"{where}:1", "a config is one")
    return tree


def plain(node: Any) -> Any:
    """Return YAML's nodes as plain Python values."""
    if isinstance(node, dict):
        return {_key(key): plain(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [plain(item) for item in node]
    for kind in (bool, int, float, str):
        if isinstance(node, kind):
            return kind(node)
    return None if node is None or isinstance(node, CommentedBase) else node


def _key(node: Any) -> Any:
    """Return a key; what cannot be one in Python is turned into text, to be refused by name."""
    key = plain(node)
    return str(key) if isinstance(key, list | dict) else key


def dump_config(data: Mapping[str, Any]) -> str:
    """Return a canonical config as YAML text."""
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.width = 120
    yaml.dump(dict(data), stream)
    return stream.getvalue()
