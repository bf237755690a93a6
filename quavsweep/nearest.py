"""What a user may have meant by a name that is not known."""

from __future__ import annotations

import difflib
from collections.abc import Sequence


def nearest(word: str, names: Sequence[str]) -> str:
    """Return a question after the name that comes nearest to a word, empty if none does."""
    near = difflib.get_close_matches(word, names, 1)
    return f", did you mean {near[0]}?" if near else ""
