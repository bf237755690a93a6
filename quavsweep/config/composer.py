"""From the events of a YAML parser to a tree of plain values; it knows the key that is being read."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import takewhile
from typing import Any, NoReturn

from ruamel.yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    DocumentStartEvent,
    Event,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
)

from quavsweep.config.place import Document, Keys, Place, Spot
from quavsweep.config.scalar import scalar
from quavsweep.config.unprintable import SUBSTITUTE, Unprintable

MAX_DEPTH = 20
MAX_SCALAR = 1000  # characters; integers of more than 4300 digits cannot even be read


@dataclass
class Level:
    """A mapping or list that is being read; `waiting` says whether a key has been read and its value has not."""

    keys: Keys
    node: dict[str, Any] | list[Any]
    index: int
    column: int
    flow: bool
    last: Keys | None = None
    waiting: bool = False


class Composer:
    """Builds the tree and the places of its keys; refuses what a config may not hold.

    Parameters
    ----------
    start : Spot
        The first line of the text, or the override that it is the value of.
    root : tuple of str
        The keys under which the text stands.
    unprintable : Unprintable, optional
        The first character that may not be in the text.
    """

    def __init__(self, start: Spot, root: Keys = (), unprintable: Unprintable | None = None) -> None:
        self.document = Document(start)
        self.root, self.unprintable = root, unprintable
        self.levels: list[Level] = []
        self.documents = 0

    @property
    def keys(self) -> Keys:
        """The innermost key that is being read, or that was read last."""
        if not self.levels:
            return self.root
        return self.levels[-1].last or self.levels[-1].keys

    def refuse(self, keys: Keys, what: str, possible: str = "", line: int = 0) -> NoReturn:
        """Raise the error that names these keys, and the line of what is wrong if it is another one than theirs."""
        other = f" (line {line})" if self.document.place.line(keys) not in (0, line) and line else ""
        raise self.document.place.error(keys, what + other, possible)

    def _refuse_unprintable(self, keys: Keys, unprintable: Unprintable) -> NoReturn:
        """Raise the error that names these keys, without the substitute that one of them may hold."""
        clean = tuple(_readable(key) if isinstance(key, str) else key for key in keys)
        self.document.spots |= {clean: self.document.place.spot(keys)} if clean else {}
        self.refuse(clean, unprintable.what, line=unprintable.line)

    def feed(self, event: Event) -> None:
        """Take the next event."""
        if self.unprintable and event.start_mark.index > self.unprintable.index:
            self._refuse_unprintable(self.keys, self.unprintable)
        if isinstance(event, DocumentStartEvent):
            self._begin(event)
        elif isinstance(event, CollectionEndEvent):
            self.levels.pop()
        elif isinstance(event, NodeEvent):
            level = self.levels[-1] if self.levels else None
            if level and isinstance(level.node, dict) and not level.waiting:
                self._take_key(level, event)
            else:
                self._take_value(level, event)

    def _begin(self, event: DocumentStartEvent) -> None:
        self.documents += 1
        spot = self.document.start.at(event.start_mark.line + 1)
        if event.version not in (None, (1, 2)):
            raise Place(spot, {}).error((), "is not YAML 1.2")
        if self.documents > 1:
            raise Place(spot, {}).error((), "a second document begins here", "a config is one document")

    def _take_key(self, level: Level, event: NodeEvent) -> None:
        if not isinstance(event, ScalarEvent):
            self.document.spots[level.keys] = self.document.start.at(event.start_mark.line + 1)
            self._check_node(level.keys, event)
            self.refuse(level.keys, "a key here is a list or a mapping", "keys are words")
        keys = (*level.keys, event.value)
        earlier = self.document.spots.get(keys)
        self.document.spots[keys] = self.document.start.at(event.start_mark.line + 1)
        level.last, level.waiting = keys, True
        self._check_node(keys, event)
        if event.value in level.node:
            line = f" on line {earlier.line}" if earlier and earlier.line else ""
            self.refuse(keys, f"duplicate key; it is given{line} already", "keep one of them")
        if event.value == "<<" and event.implicit[0]:
            self.refuse(keys, "merging mappings is not allowed", "write the keys out")
        assert isinstance(level.node, dict)
        level.node[event.value] = None

    def _take_value(self, level: Level | None, event: NodeEvent) -> None:
        keys = self.root if level is None else self._key_of_value(level, event)
        self._check_node(keys, event)
        value: Any
        if isinstance(event, ScalarEvent):
            value = scalar(event.value) if event.implicit[0] else event.value
            if event.implicit[0]:
                self.document.words[keys] = event.value
        else:
            value = {} if isinstance(event, MappingStartEvent) else []
        if level is None:
            self.document.tree = value
        elif isinstance(level.node, list):
            level.node.append(value)
        else:
            level.node[str(keys[-1])] = value
        if isinstance(event, CollectionStartEvent):
            mark = event.start_mark
            self.levels.append(Level(keys, value, mark.index, mark.column, bool(event.flow_style)))

    def _key_of_value(self, level: Level, event: NodeEvent) -> Keys:
        if isinstance(level.node, list):
            keys = (*level.keys, len(level.node))
            self.document.spots[keys] = self.document.start.at(event.start_mark.line + 1)
            level.last = keys
            return keys
        level.waiting = False
        assert level.last is not None
        return level.last

    def _check_node(self, keys: Keys, event: NodeEvent) -> None:
        """Refuse tags, anchors, aliases, endless scalars, depth, and what cannot be printed."""
        if self.unprintable and self.unprintable.index < event.end_mark.index:
            self._refuse_unprintable(keys, self.unprintable)
        line = event.start_mark.line + 1
        if isinstance(event, AliasEvent) or event.anchor is not None:
            self.refuse(keys, "anchors and aliases are not allowed", "write the value out", line)
        if isinstance(event, ScalarEvent | CollectionStartEvent) and event.tag is not None:
            self.refuse(keys, "tags are not allowed", "write the value alone", line)
        if isinstance(event, ScalarEvent) and len(event.value) > MAX_SCALAR:
            what = f"{event.value[:10]}... has {len(event.value)} characters, which is too long"
            self.refuse(keys, what, f"at most {MAX_SCALAR} characters", line)
        if len(self.levels) + len(self.root) >= MAX_DEPTH and isinstance(event, CollectionStartEvent):
            named = tuple(takewhile(lambda key: isinstance(key, str), keys))
            self.refuse(named, f"nested deeper than {MAX_DEPTH}", line=line)


def _readable(key: str) -> str:
    """Return the word in a key that holds a substitute for what cannot be printed."""
    words = re.findall(r"[\w.-]+", key.replace(SUBSTITUTE, "").split(":")[0]) if SUBSTITUTE in key else ()
    return words[-1] if words else key
