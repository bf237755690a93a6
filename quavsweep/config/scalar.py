"""What a word of YAML means: null, true or false, a whole number, a number, or text (YAML 1.2, the core schema)."""

from __future__ import annotations

import re

# https://yaml.org/spec/1.2.2/#103-core-schema; so `no` and `1_000` are text and 1e-3 is a number.
NULL = re.compile(r"|~|null|Null|NULL")
BOOL = re.compile(r"true|True|TRUE|false|False|FALSE")
DECIMAL = re.compile(r"[-+]?[0-9]+")
OCTAL = re.compile(r"0o[0-7]+")
HEXADECIMAL = re.compile(r"0x[0-9a-fA-F]+")
NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
SPECIAL = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")

Scalar = None | bool | int | float | str


def scalar(word: str) -> Scalar:
    """Return the value of a word without quotes."""
    if NULL.fullmatch(word):
        return None
    if BOOL.fullmatch(word):
        return word[0] in "tT"
    for pattern, base in ((DECIMAL, 10), (OCTAL, 8), (HEXADECIMAL, 16)):
        if pattern.fullmatch(word):
            return int(word, base)
    if NUMBER.fullmatch(word):
        return float(word)
    if SPECIAL.fullmatch(word):
        return float(word.replace(".", "", 1))
    return word
