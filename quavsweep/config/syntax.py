"""Where a YAML text stopped making sense, and why, in words: the key that was being read, and the parser's problem."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import CollectionEndEvent, Event
from ruamel.yaml.scanner import ScannerError

from quavsweep.config.composer import Composer, Level
from quavsweep.config.place import Keys, Place
from quavsweep.errors import ConfigError

WORD = re.compile(r"[\t ]*([\w.-]+)")
KEY = re.compile(WORD.pattern + r"[\t ]*:(?=\s|$)")

SENTENCES = (
    ("could not find expected ':'", "has no ':' after it"),
    ("found unexpected end of stream", "its quotation mark is not closed"),
    ("found unexpected document separator", "its quotation mark is not closed"),
    ("found character '\\t'", "a tab stands where only spaces may; use spaces"),
    ("cannot start any token", "{found} cannot begin a value; put the value in quotes"),
    ("mapping values are not allowed", "a second ':' is not allowed here"),
    ("sequence entries are not allowed", "a list cannot begin here; write [a, b] or begin it on a line of its own"),
    ("expected <block end>, but found '<block mapping start>'", "is not indented like its neighbours"),
    ("expected <block end>", "does not belong to what stands before it; mind the indentation"),
    ("expected the node content", "a value is expected, not {found}"),
    ("found unknown escape character", "{found} is not known after a \\; single quotes take a \\ as it is"),
    ("found undefined tag handle", "tags are not allowed"),
)


def events(text: str) -> Iterator[Event]:
    """Yield the events of a YAML text.

    Raises
    ------
    MarkedYAMLError
        Whatever goes wrong in the parser.
    """
    try:
        yield from YAML(typ="safe", pure=True).parse(text)
    except MarkedYAMLError:
        raise
    except (ArithmeticError, AssertionError, AttributeError, LookupError, RecursionError) as error:
        raise MarkedYAMLError(problem="cannot be parsed") from error
    except (TypeError, ValueError, YAMLError) as error:
        raise MarkedYAMLError(problem="cannot be parsed") from error


def syntax_error(error: MarkedYAMLError, text: str, composer: Composer) -> ConfigError:
    """Return the error in words; the composer is the one that had read the text when the parser gave up."""
    unprintable = composer.unprintable
    mark = _begin(error)
    index = len(text) if mark is None else mark.index
    if unprintable and unprintable.index <= index:
        before = read_until(text, unprintable.index, composer)
        return Place(composer.start, before.spots).error(before.keys, unprintable.what)
    return _Suspect(error, text, read_until(text, index, composer)).error()


def read_until(text: str, index: int, composer: Composer) -> Composer:
    """Return what a composer knows before an index of the text: open mappings and lists stay open."""
    before = Composer(composer.start, composer.root)
    try:
        for event in events(text[:index]):
            if isinstance(event, CollectionEndEvent) and event.start_mark.index >= index:
                break
            before.feed(event)
    except MarkedYAMLError:
        pass
    return before


def _begin(error: MarkedYAMLError) -> Any:
    """Return the mark where the piece begins that could not be read."""
    if isinstance(error, ScannerError) and error.context_mark is not None:
        return error.context_mark
    return error.problem_mark or error.context_mark


class _Suspect:
    """The key that is probably to blame for an error of the parser.

    Parameters
    ----------
    error : MarkedYAMLError
        What the parser says.
    text : str
        What it read.
    before : Composer
        What was understood before the error.
    """

    def __init__(self, error: MarkedYAMLError, text: str, before: Composer) -> None:
        self.problem = " ".join((error.problem or "cannot be parsed").split())
        self.context, self.text, self.before = error.context_mark, text, before
        self.mark, self.piece = error.problem_mark or error.context_mark, _begin(error)

    def error(self) -> ConfigError:
        """Return the error that names it."""
        ways: tuple[Callable[[], ConfigError | None], ...] = (self._unclosed, self._continued, self._at_key)
        return next((found for way in ways if (found := way()) is not None), None) or self._innermost()

    def _unclosed(self) -> ConfigError | None:
        """A bracket that is not closed before something on a later line."""
        begins = self.context.index if self.context else -1
        level = next((level for level in self.before.levels if level.index == begins and level.flow), None)
        if level is None or self.mark.line + 1 == self.before.spots.get(self.before.keys, self.before.start).line:
            return None
        place = Place(self.before.start, self.before.spots)
        close = "}" if isinstance(level.node, dict) else "]"
        what = f"its {'{' if close == '}' else '['} is not closed by {close}{self._where(place, level.keys)}"
        if self.before.keys != level.keys:
            what += f"; the last key read is {place.other(self.before.keys, level.keys)}"
        return place.error(level.keys, what)

    def _continued(self) -> ConfigError | None:
        """A ':' in what seems to continue the line before: that one lacks a ':', or this one is indented too far."""
        if not self.problem.startswith("mapping values are not allowed"):
            return None
        lines = self.text.splitlines()
        here = KEY.match(lines[self.mark.line])
        if here is None or here.end() - 1 != self.mark.column:
            return None
        above = next((n for n in range(self.mark.line - 1, -1, -1) if _content(lines[n])), None)
        if above is None:
            return None
        word = WORD.match(lines[above])
        if word and ":" not in _content(lines[above]):
            return self._named(word.group(1), above, self.before.keys, "has no ':' after it")
        keys = self.before.levels[-1].keys if self.before.levels else self.before.root
        return self._named(here.group(1), self.mark.line, keys, "is indented further than the key before it")

    def _at_key(self) -> ConfigError | None:
        """A key that begins where the parser failed."""
        begin = self.text.rfind("\n", 0, self.piece.index) + 1 if self.piece else 0
        if self.piece is None or self.text[begin : self.piece.index].strip():
            return None
        colon_missing = "could not find expected ':'" in self.problem
        word = (WORD if colon_missing else KEY).match(self.text, self.piece.index)
        if word is None:
            return None
        return self._named(word.group(1), self.piece.line, self._section(self.piece.column).keys, self._sentence())

    def _innermost(self) -> ConfigError:
        """The key that was being read."""
        keys, place = self.before.keys, Place(self.before.start, self.before.spots)
        if not keys and self.mark is not None:
            place = Place(self.before.start.at(self.mark.line + 1), {})
        return place.error(keys, self._sentence() + self._where(place, keys))

    def _named(self, word: str, line: int, section: Keys, what: str) -> ConfigError:
        """Return the error of a key that the parser has not accepted as one."""
        keys = (*section, word)
        spots = self.before.spots | {keys: self.before.start.at(line + 1)}
        return Place(self.before.start, spots).error(keys, what)

    def _section(self, column: int) -> Level:
        """Return the mapping to which a key in this column belongs."""
        open_levels = [level for level in self.before.levels if isinstance(level.node, dict)]
        if "\\t" in self.problem:
            return open_levels[-1] if open_levels else Level(self.before.root, {}, 0, 0, flow=False)
        fitting = [level for level in open_levels if level.flow or level.column <= column]
        return fitting[-1] if fitting else Level(self.before.root, {}, 0, 0, flow=False)

    def _where(self, place: Place, keys: Keys) -> str:
        """Return the line where the parser failed, if it is not the key's."""
        line = self.mark.line + 1 if self.mark is not None else 0
        return f" before line {line}" if place.line(keys) not in (0, line) and line else ""

    def _sentence(self) -> str:
        """Return the parser's problem in words."""
        found = re.search(r"'(?:\\.|[^'\\])+'$|(?<=found character )'.+?'(?= that)", self.problem)
        for problem, sentence in SENTENCES:
            if problem in self.problem:
                return sentence.format(found=found.group() if found else "this")
        return self.problem


def _content(line: str) -> str:
    """Return a line without its comment and surrounding blanks."""
    return line.split("#", maxsplit=1)[0].strip()
