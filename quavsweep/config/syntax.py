"""Where a YAML text stopped making sense, and why, in words: the key that was being read, and the parser's problem."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from enum import Enum
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import CollectionEndEvent, Event
from ruamel.yaml.scanner import ScannerError

from quavsweep.config.composer import Composer
from quavsweep.config.place import Document, Keys, Place
from quavsweep.errors import ConfigError

WORD = re.compile(r"[\t ]*([\"']?)([\w.-]+)\1")
KEY = re.compile(WORD.pattern + r"[\t ]*:(?=\s|$)")

SENTENCES = (
    ("could not find expected ':'", "has no ': ' after it"),
    ("found unexpected end of stream", "its quotation mark is not closed"),
    ("found unexpected document separator", "its quotation mark is not closed"),
    ("found character '\\t'", "a tab stands where only spaces may; use spaces"),
    ("cannot start any token", "{found} cannot begin a value; put the value in quotes"),
    ("mapping values are not allowed", "a second ':' is not allowed here"),
    ("sequence entries are not allowed", "a list cannot begin here; write [a, b]"),
    ("expected <block end>, but found '<block mapping start>'", "is not indented like its neighbours"),
    ("expected <block end>", "{found} does not belong here; mind brackets and indentation"),
    ("expected '<document start>'", "{found} does not belong here; mind brackets and indentation"),
    ("expected the node content", "a value is expected, not {found}"),
    ("expected escape sequence", "what stands after a \\ is not complete; single quotes take a \\ as it is"),
    ("found unknown escape character", "{found} is not known after a \\; single quotes take a \\ as it is"),
    ("found undefined tag handle", "tags are not allowed"),
)


class Brackets(Enum):
    """What seems to be wrong with the brackets of a text."""

    FINE = "nothing"
    OPEN = "one is not closed"
    CLOSED_EARLY = "one is closed that was not opened, or too early"


class UnreadableError(ConfigError):
    """A text that is not YAML; carries what was read before, the keys that are named, and what the brackets are."""

    def __init__(self, error: ConfigError, document: Document, keys: Keys, brackets: Brackets = Brackets.FINE) -> None:
        super().__init__(error.what, error.where, error.possible)
        self.document, self.keys, self.brackets = document, keys, brackets


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
    piece = _begin(error)
    index = len(text) if piece is None else piece.index
    if unprintable and unprintable.index <= index:
        before = read_until(text, unprintable.index, composer)
        before.refuse(before.keys, unprintable.what, line=unprintable.line)
    return Suspect(error, text, read_until(text, index, composer)).error()


def read_until(text: str, index: int, composer: Composer) -> Composer:
    """Return what a composer knows before an index of the text: open mappings and lists stay open."""
    before = Composer(composer.document.start, composer.root)
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


class Suspect:
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
        self.context_words = error.context or ""
        self.context, self.text, self.before = error.context_mark, text, before
        self.mark, self.piece = error.problem_mark or error.context_mark, _begin(error)
        self.place = before.document.place

    def error(self) -> ConfigError:
        """Return the error that names it."""
        ways: tuple[Callable[[], ConfigError | None], ...] = (self._unclosed, self._continued, self._at_key)
        return next((found for way in ways if (found := way()) is not None), None) or self._innermost()

    def _unclosed(self) -> ConfigError | None:
        """A bracket that is not closed before something on a later line."""
        begins = self.context.index if self.context else -1
        level = next((level for level in self.before.levels if level.index == begins and level.flow), None)
        last = self.before.keys
        if level is None or self.mark.line + 1 == self.place.line(last):
            return None
        brackets = "{}" if isinstance(level.node, dict) else "[]"
        what = f"its {brackets[0]} is not closed by {brackets[1]}{self._where(level.keys)}"
        keys = level.keys
        if not keys:
            keys, what = last, what.replace("its", "the first")
            last = self._last_inside(keys)
        if last != keys:
            what += f"; the last key read is {self.place.other(last, keys)}"
        return UnreadableError(self.place.error(keys, what), self.before.document, keys, Brackets.OPEN)

    def _continued(self) -> ConfigError | None:
        """A ':' in what seems to continue the line before: that one lacks a ':', or this one is indented too far."""
        if not self.problem.startswith("mapping values are not allowed"):
            return None
        lines = re.split(r"\r\n?|\n", self.text)
        here = KEY.match(lines[self.mark.line])
        above = next((n for n in range(self.mark.line - 1, -1, -1) if _content(lines[n])), None)
        if here is None or here.end() - 1 != self.mark.column or above is None:
            return None
        word = WORD.match(lines[above])
        if word and not KEY.match(lines[above]):
            return self._named(word.group(2), above, self.before.keys, "has no ': ' after it")
        section = self.before.levels[-1].keys if self.before.levels else self.before.root
        return self._named(here.group(2), self.mark.line, section, "is indented further than", [self.before.keys])

    def _at_key(self) -> ConfigError | None:
        """A key that begins where the parser failed."""
        begin = self.text.rfind("\n", 0, self.piece.index) + 1 if self.piece else 0
        if self.piece is None or self.text[begin : self.piece.index].strip():
            return None
        colon_missing = "could not find expected ':'" in self.problem
        word = (WORD if colon_missing else KEY).match(self.text, self.piece.index)
        if word is None and not colon_missing:
            return None
        section, neighbours = self._section(self.piece.column)
        name, what = word.group(2) if word else None, self._sentence()
        if "<block mapping start>" in self.problem:
            what, beside = f"is not indented like{' its neighbours' * (not neighbours)}", neighbours
        else:
            beside = [self.before.keys] if colon_missing and self.before.keys else []
            what += "; the key before it is" if beside else ""
        return self._named(name, self.piece.line, section, what, beside)

    def _innermost(self) -> ConfigError:
        """The key that was being read; after a bracket that closes too much, the key before that bracket."""
        keys = self.before.keys
        document = self.before.document
        if self._after_bracket() and document.spots:
            keys = list(document.spots)[-1]
        if not keys and self.mark is not None:
            document = Document(document.start.at(self.mark.line + 1))
        error = document.place.error(keys, self._sentence() + self._where(keys))
        return UnreadableError(error, self.before.document, keys, self._brackets())

    def _last_inside(self, keys: Keys) -> Keys:
        """Return the last key of a section, or the section's own."""
        inside = (known[: len(keys) + 1] for known in reversed(self.place.spots) if known[: len(keys)] == keys)
        return next(inside, keys)

    def _after_bracket(self) -> bool:
        """Whether the parser failed right after a closing bracket."""
        return self.piece is not None and self.text[: self.piece.index].rstrip()[-1:] in ("}", "]")

    def _brackets(self) -> Brackets:
        """Return what seems to be wrong with the brackets."""
        here = self.text[self.piece.index : self.piece.index + 1] if self.piece else ""
        if self._after_bracket() or here in ("}", "]"):
            return Brackets.CLOSED_EARLY
        return Brackets.OPEN if "flow" in self.context_words else Brackets.FINE

    def _named(self, word: str | None, line: int, section: Keys, what: str, beside: Sequence[Keys] = ()) -> ConfigError:
        """Return the error of a key that the parser has not accepted as one; it may be compared with others."""
        keys = section if word is None else (*section, word)
        place = Place(self.place.start, self.place.spots | {keys: self.place.start.at(line + 1)})
        compared = " or ".join(place.other(other, keys) for other in beside)
        return UnreadableError(place.error(keys, f"{what} {compared}".strip()), self.before.document, keys)

    def _section(self, column: int) -> tuple[Keys, list[Keys]]:
        """Return the mapping to which a key in this column belongs, and the keys indented a little less and more."""
        levels = [level for level in self.before.levels if isinstance(level.node, dict)]
        if "\\t" in self.problem:
            last = self.before.keys
            return (last if self.before.document.words.get(last) == "" or not levels else levels[-1].keys), []
        fitting = [level for level in levels if level.flow or level.column <= column]
        deeper = [level.last for level in levels if level not in fitting]
        near = [fitting[-1].last if fitting else None, deeper[0] if deeper else None]
        return (fitting[-1].keys if fitting else self.before.root), [keys for keys in near if keys]

    def _where(self, keys: Keys) -> str:
        """Return the line where the parser failed, if it is not the key's."""
        line = self.mark.line + 1 if self.mark is not None else 0
        return f" before line {line}" if keys and self.place.line(keys) not in (0, line) and line else ""

    def _sentence(self) -> str:
        """Return the parser's problem in words."""
        found = re.search(r"(?:character|found|got) \(?('.+?')", self.problem)
        shown = found.group(1).replace("'<stream end>'", "the end of the text") if found else "what follows"
        for problem, sentence in SENTENCES:
            if problem in self.problem:
                return sentence.format(found=shown)
        return self.problem


def _content(line: str) -> str:
    """Return a line without its comment and surrounding blanks."""
    return line.split("#", maxsplit=1)[0].strip()
