"""Characters that may not be in a YAML text: control characters, and bytes that are not UTF-8."""

from __future__ import annotations

import re
from dataclasses import dataclass

# https://yaml.org/spec/1.2.2/#51-character-set
UNPRINTABLE = re.compile("[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
SUBSTITUTE = "\ufffd"


@dataclass(frozen=True)
class Unprintable:
    """The first such character of a text: its index, its line (from 1), and what is wrong with it."""

    index: int
    line: int
    what: str


def decoded(text: str | bytes) -> str:
    """Return a text; bytes that are not UTF-8 become lone surrogates."""
    return text.decode("utf-8", errors="surrogateescape") if isinstance(text, bytes) else text


def printable(text: str) -> tuple[str, Unprintable | None]:
    """Return the text with a substitute for every such character, and the first of them."""
    found = UNPRINTABLE.search(text)
    if found is None:
        return text, None
    line = text.count("\n", 0, found.start()) + 1
    return UNPRINTABLE.sub(SUBSTITUTE, text), Unprintable(found.start(), line, _what(ord(found.group())))


def _what(code: int) -> str:
    if 0xDC80 <= code <= 0xDCFF:
        return f"the byte 0x{code - 0xDC00:02x} is not UTF-8 text"
    return f"the character U+{code:04X} is not allowed"
