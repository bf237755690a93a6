"""What was read, where each key was written, and the error that names it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from quavsweep.errors import ConfigError

Keys = tuple[str | int, ...]

LONGEST = 60  # characters of a user's text that a message repeats


@dataclass(frozen=True)
class Spot:
    """A line of a file, counted from 1; or, with line 0, an override of the command line."""

    where: str
    line: int = 0

    def __str__(self) -> str:
        return f"{self.where}:{self.line}" if self.line else self.where

    def at(self, line: int) -> Spot:
        """Return the spot of another line; an override has no lines."""
        return Spot(self.where, line) if self.line else self


@dataclass
class Document:
    """A text as a tree of plain values, the place of each key, and the words that were written without quotes."""

    start: Spot
    tree: Any = None
    spots: dict[Keys, Spot] = field(default_factory=dict)
    words: dict[Keys, str] = field(default_factory=dict)

    @property
    def place(self) -> Place:
        """What finds the place of a key."""
        return Place(self.start, self.spots)

    def before(self, keys: Keys) -> Keys:
        """Return the key that was written before another one."""
        known = list(self.spots)
        at = known.index(keys) if keys in self.spots else 0
        return known[at - 1] if at else ()


class Place:
    """Knows where each key was written.

    Parameters
    ----------
    start : Spot
        The place of what has no key.
    spots : dict from keys to Spot
        The places of the keys; a list's items have their index, from 0, as the last key.
    """

    def __init__(self, start: Spot, spots: dict[Keys, Spot]) -> None:
        self.start, self.spots = start, spots

    def has(self, keys: Keys) -> bool:
        """Whether the key itself was written."""
        return keys in self.spots

    def spot(self, keys: Keys) -> Spot:
        """Return the place of the innermost of these keys that was written."""
        lengths = range(len(keys), -1, -1)
        return next((self.spots[keys[:n]] for n in lengths if keys[:n] in self.spots), self.start)

    def line(self, keys: Keys) -> int:
        """Return its line, counted from 1; 0 for an override."""
        return self.spot(keys).line

    def error(self, keys: Keys, what: str, possible: str = "") -> ConfigError:
        """Return the error that names file, line and key."""
        key = dotted(keys)
        where = f"{self.spot(keys)}" + (f": {key}" if key else "")
        return ConfigError(*(_one_line(part) for part in (what, where, possible)))

    def other(self, keys: Keys, than: Keys) -> str:
        """Return the name of a second key, with its place unless it is that of the first."""
        here, there = self.spot(keys), self.spot(than)
        if here == there or not self.has(keys):
            return dotted(keys)
        return f"{dotted(keys)} (line {here.line})" if here == there.at(here.line) else f"{dotted(keys)} ({here})"


def dotted(keys: Keys) -> str:
    """Return `axes.c.num`, or `axes.c.values (item 2)`."""
    parts = (f" (item {key + 1})" if isinstance(key, int) else f".{_word(key)}" for key in keys)
    return "".join(parts).removeprefix(".")


def _word(key: str) -> str:
    """Return a key as it can stand in a message of one line."""
    return key if key.isprintable() and key.strip() == key != "" and len(key) <= LONGEST else quoted(key)


def quoted(text: str) -> str:
    """Return a text of the user in quotes, on one line, shortened."""
    return repr(text if len(text) <= LONGEST else text[: LONGEST - 3] + "...")


def escaped(text: str) -> str:
    """Return a text of the user without quotes, on one line, shortened."""
    return _one_line(text if len(text) <= LONGEST else text[: LONGEST - 3] + "...")


def _one_line(text: str) -> str:
    """Return a text with escapes for what would break the line or disturb a terminal."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
