"""Mutations of YAML configs, each of one known key: what is put where, and which key and lines a message must name."""

from __future__ import annotations

import io
import json
import random
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from ruamel.yaml import YAML


@dataclass(frozen=True)
class Entry:
    """A key of a text: its path, and where key and value begin and end; `item` for an item of a list."""

    path: tuple[str, ...]
    key: tuple[int, int]
    value: tuple[int, int]
    parent: int  # index at which the key of its mapping begins, or 0
    item: bool = False


@dataclass(frozen=True)
class Mutant:
    """A mutated text, what was done, and what has to be named: one of the paths, on one of the lines."""

    text: bytes
    kind: str
    paths: tuple[tuple[str, ...], ...]
    lines: frozenset[int]


def entries(text: str) -> list[Entry]:
    """Return every key of a YAML text, and every item of a list."""
    return list(_walk(YAML(typ="safe", pure=True).compose(text), text, (), 0))


def _walk(node: Any, text: str, path: tuple[str, ...], parent: int) -> Iterator[Entry]:
    for key, value in node.value:
        here = (*path, key.value)
        span = (key.start_mark.index, key.end_mark.index)
        yield Entry(here, span, _span(value, text), parent)
        if value.id == "mapping":
            yield from _walk(value, text, here, span[0])
        elif value.id == "sequence":
            yield from (Entry(here, span, _span(item, text), parent, item=True) for item in value.value)


def _span(node: Any, text: str) -> tuple[int, int]:
    """Return where a node begins and ends; a block ends where the next key begins, which is not meant."""
    begin, end = node.start_mark.index, node.end_mark.index
    return begin, begin + len(text[begin:end].rstrip())


def styles(text: str) -> list[str]:
    """Return a config as it is, in block style, in flow style, as JSON, and with the line ends of Windows."""
    tree = YAML(typ="safe", pure=True).load(text)
    return [
        text,
        _dump(tree, flow=False),
        _dump(tree, flow=True),
        json.dumps(tree, indent=2),
        text.replace("\n", "\r\n"),
    ]


def _dump(tree: Any, flow: bool) -> str:
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = flow
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.dump(tree, stream)
    return stream.getvalue()


TYPES = (
    *("abc", "true", "yes", "[1, 2]", "[a]", "{a: 1}", "{}", "[]", "null", "~", "", "''", '"5"', "'0.5'", "[[1]]"),
    *("2001-01-01", "2001-13-45", "12:30:45", "1_000", "400,5", "1e", "0x1F", "0b11", "+", "-", "1.2.3", "50 rad/s"),
    *(
        "'a b'",
        "ä",
        "../x",
        "a/b",
        "'a\\nb'",
        '"a\\nb"',
        '"a\\x07b"',
        "x" * 300,
        "x" * 3000,
        "[1, [2, 3]]",
        "{a: {b: 1}}",
    ),
)
NUMBERS = (
    *(".inf", "-.inf", ".nan", "0", "-1", "-0.5", "1e400", "-1e400", "1e300", "-1e300", "1e-320", "1.5", "2", "1e6"),
    *(str(10**18), "9" * 400, "9" * 5000, "-" + "9" * 5000, "0x" + "f" * 5000, "1e-5", "1e5", "0.0", "1" + "0" * 309),
)
TAGS = ("!!str 5", "!!float 1", "!foo 1", "! 1", "!!python/object/apply:os.system [ls]", "!<tag:x> 1", "!!set {a}")
ALIASES = ("&a 1", "*a", "&a [1]", "{<<: {a: 1}}", "&a", "{<<: *a}")
OPEN = ("[{}", "{{{}", '"{}', "'{}", "{}]", "{}}}", "[{}, 2", "{{a: {}", "[[{}]", '{}"', '"{}" 5', "{}, ")
SYNTAX = (
    "{}: 5",
    "@{}",
    "`{}",
    "%{}",
    "- {}",
    "|",
    "> {}",
    "\t{}",
    '"\\q"',
    "{} {}",
    "? {}",
    "{}: {{",
    ": {}",
    '"\\xzz"',
)
INSIDE = ("\x07", "\x00", "\x1b[31m", "\x7f", "\x9b", "\ufffe", "\udcff", "\udcc3(", "\udce9", "\ud800")

Mutation = Callable[[random.Random, str, Entry], "tuple[str, tuple[tuple[str, ...], ...], tuple[int, ...]]"]


def _replaced(text: str, entry: Entry, new: str) -> str:
    begin, end = entry.value
    return text[:begin] + new + text[end:]


def value_mutation(words: tuple[str, ...]) -> Mutation:
    """Return the mutation that puts another value; {} stands for the old one."""

    def mutate(rng: random.Random, text: str, entry: Entry) -> Any:
        old = text[slice(*entry.value)]
        word = rng.choice(words)
        new = word.format(*[old] * word.count("{")) if words in (OPEN, SYNTAX) else word
        rows = [i for i, c in enumerate(new, 1) if c == "\n"] if words in (OPEN, SYNTAX) else []
        return _replaced(text, entry, new), (entry.path,), (entry.key[0], *(entry.value[0] + i for i in (0, *rows)))

    return mutate


def put_inside(rng: random.Random, text: str, entry: Entry) -> Any:
    """Put a character that may not be there into the value, in quotes or not."""
    old = text[slice(*entry.value)]
    at = rng.randrange(len(old) + 1)
    new = old[:at] + rng.choice(INSIDE) + old[at:]
    first_line = at <= (old + "\n").index("\n")
    quote = rng.choice(["", "", '"']) if first_line and old[:1] not in "\"'[{" and "\n" not in old else ""
    line = text.count("\n", 0, entry.value[0] + at)
    inner = [e.path for e in entries(text) if e.path[: len(entry.path)] == entry.path and _line(text, e) == line]
    return _replaced(text, entry, f"{quote}{new}{quote}"), (entry.path, *inner), (entry.key[0], entry.value[0] + at)


def _line(text: str, entry: Entry) -> int:
    return text.count("\n", 0, entry.key[0])


def cut(rng: random.Random, text: str, entry: Entry) -> Any:
    """Forget the bracket or quotation mark at the end of the value, or at its beginning."""
    old = text[slice(*entry.value)]
    if old[-1:] not in ("}", "]", '"', "'"):
        return text, (entry.path,), (entry.key[0],)
    new = rng.choice([old[:-1], old[1:]])
    return _replaced(text, entry, new), (entry.path,), (entry.key[0], entry.value[0])


def delete(rng: random.Random, text: str, entry: Entry) -> Any:
    """Leave the key and its value out."""
    begin, end = entry.key[0], entry.value[1]
    rest = text[end:]
    comma = rest[: len(rest) - len(rest.lstrip(" \r\n"))] + "," if rest.lstrip(" \r\n").startswith(",") else ""
    head = text[:begin]
    if comma:
        end += len(comma)
    elif head.rstrip(" \r\n").endswith(","):
        head = head.rstrip(" \r\n")[:-1]
    # A block without keys is an empty value of its own key.
    paths = (entry.path, entry.path[:-1]) if re.search(r":\s*$", head) else (entry.path,)
    return head + text[end:], paths, (entry.parent,)


def _separator(text: str, entry: Entry) -> str:
    """Return what stands between a key and the one before: a comma, or a line break and the indentation."""
    before = text[: entry.key[0]]
    indentation = before[before.rfind("\n") + 1 :]
    return ", " if indentation.strip() or text.lstrip().startswith("{") else "\n" + indentation


def duplicate(rng: random.Random, text: str, entry: Entry) -> Any:
    """Write the key twice, with the same value or another."""
    separator = _separator(text, entry)
    new = text[entry.key[0] : entry.value[1]]
    if rng.random() < 0.5:
        new = text[entry.key[0] : entry.value[0]] + rng.choice(["1", "x", "[1]"])
    again = entry.key[0] + len(new) + len(separator)
    return text[: entry.key[0]] + new + separator + text[entry.key[0] :], (entry.path,), (entry.key[0], again)


def misspell(rng: random.Random, text: str, entry: Entry) -> Any:
    """Change letters of the key."""
    key = entry.path[-1]
    at = rng.randrange(len(key))
    ways = (
        key[:at] + key[at + 1 :],
        key[:at] + key[at] + key[at:],
        key[:at] + rng.choice("abcxyz019_-.") + key[at + 1 :],
        key[:at] + key[at + 1 : at + 2] + key[at] + key[at + 2 :],
        key.upper() if key.upper() != key else key.lower(),
        key + rng.choice(["s", "_", "1", " ", "ä", "\u0430", "-x", "\u200b", ".x"]),
        rng.choice(["s", "_", "x", "\u0430", "\u00a0"]) + key,
    )
    new = rng.choice(ways)
    new = new.strip(" ")
    shown = new if new.isprintable() and new == new.strip() else repr(new)
    return _renamed(text, entry, new), (entry.path, (*entry.path[:-1], shown)), (entry.key[0],)


def odd_key(rng: random.Random, text: str, entry: Entry) -> Any:
    """Put something that is no word in the key's place."""
    new = rng.choice(
        [
            "[a, b]",
            "{a: 1}",
            "null",
            "~",
            "1",
            "1.5",
            "true",
            '""',
            "<<",
            "*a",
            "!!str k",
            "&a k",
            "? k",
            "'a\n b'",
            '"a\\nb"',
            "k" * 200,
            "k" * 3000,
        ]
    )
    names = {"!!str k": "k", "&a k": "k", "? k": "k", '""': "''", "'a\n b'": "a b", '"a\\nb"': "'a\\nb'"}
    name = names.get(new, new)
    shown = repr(name[:57] + "...") if len(name) > 60 else name
    # What is not even a word has no name; the mapping in which it stands has.
    paths = [(*entry.path[:-1], shown), entry.path] + [entry.path[:-1]] * (new[0] in "[{*?'")
    return text[: entry.key[0]] + new + text[entry.key[1] :], tuple(paths), (entry.key[0],)


def _renamed(text: str, entry: Entry, new: str) -> str:
    begin, end = entry.key
    quote = text[begin] if text[begin] in "\"'" else ""
    return f"{text[:begin]}{quote}{new}{quote}{text[end:]}"


def punctuation(rng: random.Random, text: str, entry: Entry) -> Any:
    """Forget the colon, or the blank after it, or double it."""
    between = text[entry.key[1] : entry.value[0]]
    ways = [
        between.replace(":", "", 1),
        between.replace(": ", ":", 1),
        between.replace(":", "::", 1),
        between.replace(":", " =", 1),
    ]
    new = rng.choice(ways)
    joined = text[slice(*entry.key)] + new.strip() + text[slice(*entry.value)]
    return (
        text[: entry.key[1]] + new + text[entry.value[0] :],
        (entry.path, (*entry.path[:-1], joined)),
        (entry.key[0],),
    )


def indentation(rng: random.Random, text: str, entry: Entry) -> Any:
    """Indent the key's line by a blank more, a blank less, or a tab."""
    begin = text.rfind("\n", 0, entry.key[0]) + 1
    blanks = entry.key[0] - begin
    if text[begin : entry.key[0]].strip():
        return text, (entry.path,), (entry.key[0],)
    new = rng.choice([" " * (blanks + 1), " " * (blanks + 3), " " * max(blanks - 1, 0), "", "\t", " " * blanks + "\t"])
    # The indentation says in which mapping the key is.
    paths = tuple((*entry.path[:n], entry.path[-1]) for n in range(len(entry.path)))
    return text[:begin] + new + text[entry.key[0] :], paths, (begin,)


MUTATIONS: dict[str, Mutation] = {
    "type": value_mutation(TYPES),
    "number": value_mutation(NUMBERS),
    "tag": value_mutation(TAGS),
    "alias": value_mutation(ALIASES),
    "open": value_mutation(OPEN),
    "syntax": value_mutation(SYNTAX),
    "inside": put_inside,
    "cut": cut,
    "delete": delete,
    "duplicate": duplicate,
    "misspell": misspell,
    "odd key": odd_key,
    "punctuation": punctuation,
    "indentation": indentation,
}
OF_ITEMS = ("type", "number", "tag", "alias", "open", "syntax", "inside", "cut")


def mutant(rng: random.Random, text: str) -> Mutant:
    """Return a text with one key mutated."""
    entry = rng.choice(entries(text))
    kind = rng.choice(OF_ITEMS if entry.item else tuple(MUTATIONS))
    mutated, paths, indices = MUTATIONS[kind](rng, text, entry)
    lines = frozenset(mutated.count("\n", 0, index) + 1 for index in indices)
    return Mutant(
        mutated.encode("utf-8", errors="surrogateescape" if "\ud800" not in mutated else "surrogatepass"),
        kind,
        paths,
        lines,
    )
