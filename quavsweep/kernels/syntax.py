"""Digests of source code that do not see comments, docstrings or layout."""

from __future__ import annotations

import ast
import hashlib
import inspect
import textwrap
import threading
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

_PARSING = threading.Lock()  # Python 3.11's parser counts its depth wrongly where threads take turns in it


def syntax_digest(code: str | Callable[..., Any]) -> str:
    """Return the SHA-256 of the syntax tree of a module (by name) or of a function.

    Raises
    ------
    ValueError
        If there is no source.
    """
    if isinstance(code, str):
        spec = find_spec(code)
        if spec is None or spec.origin is None:
            raise ValueError(f"no source of {code}")
        text = Path(spec.origin).read_text(encoding="utf-8")
    else:
        text = textwrap.dedent(inspect.getsource(code))
    return _tree_digest(text)


@cache
def _tree_digest(text: str) -> str:
    """Return the SHA-256 of the syntax tree of a source text; a run asks for those of most modules twice."""
    with _PARSING:
        tree = ast.parse(text)
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef)
            and ast.get_docstring(node, clean=False) is not None
        ):
            node.body = node.body[1:]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()
