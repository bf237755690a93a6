"""Mistakes in the functions that a model is made of: what is wrong, in which line, and what is possible."""

from __future__ import annotations

import inspect
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

from quavsweep.errors import ModelError

DECIDING = "use where, minimum and maximum of quavsweep.models.function, or SymPy's Piecewise, Min and Max"
FUNCTIONS = "functions are those of quavsweep.models.function, or SymPy's"
_NUMBERS_ONLY = ("Cannot convert expression to float", "loop of ufunc", "must be real number", "callable")


def mistake(error: Exception, function: Callable[..., Any]) -> ModelError:
    """Return the error that calling a model's function raised as one that its author understands."""
    code = getattr(function, "__code__", None)
    return mistake_in(error, code.co_filename if code else "", place(function))


def mistake_in(error: Exception, file: str, where: str = "") -> ModelError:
    """Return the error that running a file, or a function in it, raised as one that its author understands.

    Its line is that of the innermost call in the file; `where` is told if there is none.
    """
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    where = f"{_shown(file)}:{frames[-1].lineno}" if frames else where or _shown(file)
    if isinstance(error, ModelError):
        return ModelError(error.what, error.where if ":" in error.where else where, error.possible)
    text = str(error).rstrip(".")
    if isinstance(error, NameError):
        return ModelError(text, where, "equations know their arguments, and what their file defines or imports")
    if "truth value" in text:
        return ModelError("`if`, `min`, `max` or a comparison decides by a state or parameter", where, DECIDING)
    if isinstance(error, TypeError) and any(part in text for part in _NUMBERS_ONLY):
        return ModelError(f"a function that takes only numbers got a state or parameter ({text})", where, FUNCTIONS)
    if isinstance(error, AttributeError):
        return ModelError(text, where, FUNCTIONS)
    return ModelError(f"{type(error).__name__}: {text}", where)


def place(function: Callable[..., Any], line: int | None = None) -> str:
    """Return file and line of a function, of its first line unless told."""
    code = getattr(function, "__code__", None)
    if code is None:
        return ""
    return f"{_shown(code.co_filename)}:{line or code.co_firstlineno}"


def place_of_return(function: Callable[..., Any]) -> str:
    """Return file and line of the last `return` of a function, of its first line if its source is not to be had."""
    try:
        lines, first = inspect.getsourcelines(function)
    except (OSError, TypeError):
        return place(function)
    found = [number for number, line in enumerate(lines, first) if line.lstrip().startswith("return")]
    return place(function, found[-1] if found else first)


def place_of_value(function: Callable[..., Any], call: Callable[[], Any], wrong: Callable[[Any], bool]) -> str:
    """Return file and line where a wrong value first appears while a function of a user is called.

    Parameters
    ----------
    function : callable
        The values of its file's functions are looked at, line by line.
    call : callable
        Calls it, and raises nothing.
    wrong : callable
        Whether a value is wrong; it may be of any type.

    Returns
    -------
    str
        That of the last `return` if no value was wrong.
    """
    code = getattr(function, "__code__", None)
    found: list[int] = []
    lines: dict[int, int] = {}  # that each call is in

    def look(frame: FrameType, event: str, result: Any) -> Any:
        if code is None or frame.f_code.co_filename != code.co_filename:
            return None
        values = [result] if event == "return" else list(frame.f_locals.values())
        line = frame.f_lineno if event == "return" else lines.get(id(frame), frame.f_lineno)
        if not found and any(map(wrong, values)):
            found.append(line)
        lines[id(frame)] = frame.f_lineno
        return look

    before = sys.gettrace()
    sys.settrace(look)
    try:
        call()
    finally:
        sys.settrace(before)
    return place(function, found[0]) if found else place_of_return(function)


def _shown(file: str) -> str:
    """Return a path as people read it: relative where that is shorter."""
    try:
        return str(Path(file).relative_to(Path.cwd()))
    except ValueError:
        return file
