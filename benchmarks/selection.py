"""Which rows of a table a command line names."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence


def named(names: Sequence[str], groups: Mapping[str, Collection[str]]) -> set[str]:
    """Return the keys that are meant: by the key, its beginning up to a dash, or a group; without names all.

    Parameters
    ----------
    names : sequence of str
    groups : mapping
        From each key to the groups that it is in.

    Raises
    ------
    KeyError
        With the first name that means none.
    """
    chosen = set() if names else set(groups)
    for name in names:
        keys = {key for key, group in groups.items() if name == key or name in group or key.startswith(f"{name}-")}
        if not keys:
            raise KeyError(name)
        chosen |= keys
    return chosen
