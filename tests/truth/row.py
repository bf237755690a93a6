"""A row of the table: its protocol, and the claims that measuring it gives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tests.truth.laboratory import Laboratory


@dataclass(frozen=True)
class Claim:
    """One thing that was asked, and what was measured.

    Parameters
    ----------
    asked, measured : str
        In words, with numbers and units.
    holds : bool or None
        None where a figure is only to be stated.
    setting : str
        Of what it was measured: initial state, method, dt, T.
    numbers : mapping
        All numbers, for the JSON.
    """

    asked: str
    measured: str
    holds: bool | None
    setting: str = ""
    numbers: Mapping[str, Any] = field(default_factory=dict)

    @property
    def verdict(self) -> str:
        """Holds, MISSED or stated."""
        if self.holds is None:
            return "stated"
        return "holds" if self.holds else "MISSED"


@dataclass(frozen=True)
class Row:
    """A row of the table.

    Parameters
    ----------
    key : str
        Its name on the command line; `lorenz` also names `lorenz-regimes`.
    title : str
        What it is about.
    cost : str
        What it takes on 2 cores.
    measure : callable
        Takes the laboratory, returns its claims.
    """

    key: str
    title: str
    cost: str
    measure: Callable[[Laboratory], Sequence[Claim]]


@dataclass(frozen=True)
class Outcome:
    """A row that was measured: its claims, or the error that it ended with, and the seconds it took."""

    row: Row
    claims: Sequence[Claim]
    seconds: float
    error: str = ""

    @property
    def holds(self) -> bool:
        """Whether nothing is missed."""
        return not self.error and all(claim.verdict != "MISSED" for claim in self.claims)
