"""Stored: variables with their dimensions and attributes, in memory or in a verified file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from quavsweep.grid import Axis, Grid

Part = tuple[slice | int, ...]  # of the leading dimensions
Read = Callable[[str, Part], np.ndarray]


class Variables(Mapping[str, np.ndarray]):
    """Arrays by name; each is read when it is first asked for, and kept.

    Parameters
    ----------
    names : iterable of str
    read : callable
        From a name and a part to values; the part `()` is all of them.
    """

    def __init__(self, names: tuple[str, ...], read: Read) -> None:
        self._names, self._read = dict.fromkeys(names), read
        self._held: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        """Return an array, all of it."""
        if name not in self._names:
            raise KeyError(name)
        if name not in self._held:
            self._held[name] = self._read(name, ())
        return self._held[name]

    def part(self, name: str, part: Part) -> np.ndarray:
        """Return a part of an array, without keeping it."""
        return self._held[name][part] if name in self._held else self._read(name, part)

    def __contains__(self, name: object) -> bool:
        """Whether there is an array of that name; nothing is read."""
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        """Yield the names."""
        return iter(self._names)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._names)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle as what is in it: a file stays where it is."""
        return dict, (dict(self),)


@dataclass(frozen=True)
class Stored:
    """What a result file holds: arrays, dimensions and attributes by variable, and the attributes of the file."""

    data: Mapping[str, np.ndarray]
    dims: dict[str, tuple[str, ...]]
    attributes: dict[str, dict[str, Any]]
    file_attributes: dict[str, Any]
    foreign: bool = False  # whether it comes from elsewhere

    def grid(self, name: str) -> Grid:
        """Return the grid of a variable's numbers, by the lengths of its dimensions; it is not read."""
        return Grid(tuple(Axis(dim, (0.0,) * len(self.data[dim])) for dim in self.dims[name]))

    def part(self, name: str, part: Part) -> np.ndarray:
        """Return a part of a variable; where it lies in a file, no more of it is read."""
        return self.data.part(name, part) if isinstance(self.data, Variables) else self.data[name][part]
