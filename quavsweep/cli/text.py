"""Text for people: lines that nobody need read, numbers with their units, aligned tables."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import re
import sys
import textwrap
from collections.abc import Iterable
from typing import TextIO

import click

from quavsweep.errors import ConfigError, DiskError

COLUMNS = 80
EXIT_SECOND_INTERRUPT = 130
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f]")
_UNITS = {"d": 86400.0, "h": 3600.0, "m": 60.0, "min": 60.0, "s": 1.0}


def say(text: object) -> bool:
    """Print a line and tell whether anybody may read it; that nobody does is no reason to stop."""
    try:
        click.echo(plain(text))
        sys.stdout.flush()
    except BrokenPipeError:
        deafen()
        return False
    except OSError as error:
        if error.errno == errno.ENOSPC:
            raise DiskError("cannot be written: no space left", "standard output") from error
    except (ValueError, AttributeError):
        return False
    return True


def prepare_streams() -> None:
    """Open what is closed of standard input, output and error, and let the latter escape what they cannot encode.

    A file of a run would get the number of a closed one, and libraries print to these numbers.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode))  # noqa: SIM115 # for as long as the process lives
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def deafen(stream: TextIO | None = None) -> None:
    """Send what is still to be printed (by default to standard output) nowhere, once nobody reads it."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), (stream or sys.stdout).fileno())


def drain() -> bool:
    """Print what is left before the process ends; tell whether that was possible, and nothing is left in any case."""
    done = True
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError as error:
            done = done and not (stream is sys.stdout and error.errno == errno.ENOSPC)
            deafen(stream)
        except (ValueError, AttributeError):
            pass
    return done


def warn(text: object) -> None:
    """Print a line to standard error."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        click.echo(plain(text), err=True)


def plain(text: object) -> str:
    """Return a text without what a terminal would obey: names and sentences may come from a file."""
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", str(text))


def table(rows: Iterable[tuple[str, str]]) -> str:
    """Return rows of a name and a text, aligned, long texts wrapped."""
    rows = list(rows)
    width = max((len(name) for name, _ in rows), default=0)
    wrapper = textwrap.TextWrapper(COLUMNS - width - 2, break_long_words=False, break_on_hyphens=False)
    lines = [
        f"{name if first else '':<{width}}  {part}".rstrip()
        for name, text in rows
        for first, part in zip((True, *[False] * len(text)), wrapper.wrap(text) or [""], strict=False)
    ]
    return "\n".join(lines)


def count(number: int, noun: str) -> str:
    """Return a number with its noun: `1 cell`, `1,200 cells`."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def duration(seconds: float) -> str:
    """Return a time as people say it: `4.2 s`, `77 s`, `3 min 20 s`, `2 h 5 min`, `3 d 4 h`."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    for size, unit, small, sub in ((86400, "d", 3600, "h"), (3600, "h", 60, "min"), (60, "min", 1, "s")):
        if whole >= (2 if unit == "min" else 1) * size:
            rest = whole % size // small
            return f"{whole // size} {unit}" + (f" {rest} {sub}" if rest else "")
    return f"{whole} s"


def amount(size: float) -> str:
    """Return a number of bytes as people say it."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.4g} TB"


def seconds_of(text: str) -> float:
    """Return the seconds of a time such as `3h50m`, `90s`, `2d`, `03:50:00` or `45` (seconds).

    Raises
    ------
    ConfigError
        If it is none.
    """
    parts = re.findall(r"(\d+(?:\.\d+)?)\s*(min|[dhms])", text)
    if re.fullmatch(r"\s*\d+(\.\d+)?\s*", text):
        parts = [(text.strip(), "s")]
    elif clock := re.fullmatch(r"\s*(\d+):(\d\d):(\d\d)\s*", text):
        parts = list(zip(clock.groups(), "hms", strict=True))
    elif not parts or re.sub(r"(\d+(?:\.\d+)?)\s*(min|[dhms])|\s", "", text):
        raise ConfigError(f"{text!r} is no time", possible="e.g. 3h50m, 03:50:00, 90s, 2d, or a number of seconds")
    seconds = sum(float(number) * _UNITS[unit] for number, unit in parts)
    if not 0 < seconds < 1e9:
        raise ConfigError(f"{text!r} is no time to run", possible="more than 0 s, less than 30 years")
    return seconds
