"""A row of the table: what is measured, its target, and the verdict."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from benchmarks.protocol import Protocol, Samples


@dataclass(frozen=True)
class Target:
    """A bound that a row's figure should keep."""

    bound: float
    at_least: bool

    def met(self, value: float) -> bool:
        """Whether a figure keeps the bound."""
        return value >= self.bound if self.at_least else value <= self.bound


def at_least(bound: float) -> Target:
    """Return a lower bound."""
    return Target(bound, True)


def at_most(bound: float) -> Target:
    """Return an upper bound."""
    return Target(bound, False)


@dataclass(frozen=True)
class Measurement:
    """What measuring a row gave.

    Parameters
    ----------
    values : list of float
        The row's figure, once for every pair of samples; the row's result is their median.
    samples : mapping
        Every sample of every side, in `sample_unit`.
    sample_unit : str
        Unit of the samples.
    note : str
        What a reader has to know beside the figure.
    detail : mapping
        Further data for the JSON and the pictures.
    comparable : bool
        False if a quick measurement cannot be held against the target.
    """

    values: list[float]
    samples: Samples = field(default_factory=dict)
    sample_unit: str = "ns"
    note: str = ""
    detail: Mapping[str, Any] = field(default_factory=dict)
    comparable: bool = True

    @property
    def value(self) -> float:
        """The median."""
        return statistics.median(self.values)


@dataclass(frozen=True)
class Row:
    """A row of the suite.

    Parameters
    ----------
    key : str
        Its name on the command line; `heyoka` also names `heyoka-1e-6`.
    suite : str
        The suite that it belongs to.
    title : str
        What the table calls it.
    unit : str
        Unit of its figure.
    target : Target or None
        None if the figure is only to be stated.
    measure : callable
        Takes the protocol, returns a Measurement, raises MissingError.
    needs : str
        Key of a row whose target must be met, or this one is void.
    peer : str
        Name of the peer in the picture, where the figure is how many times more time that takes.
    """

    key: str
    suite: str
    title: str
    unit: str
    target: Target | None
    measure: Callable[[Protocol], Measurement]
    needs: str = ""
    peer: str = ""


@dataclass(frozen=True)
class Outcome:
    """A row that has been measured, or the reason why not."""

    row: Row
    measurement: Measurement | None
    verdict: str
    reason: str = ""


def verdict(row: Row, measurement: Measurement, before: Mapping[str, Outcome]) -> str:
    """Return met, missed, void or stated.

    Parameters
    ----------
    before : mapping
        Outcomes of the rows measured so far, by key.
    """
    foundation = before.get(row.needs)
    if foundation is not None and foundation.verdict in ("missed", "missing", "failed"):
        return "void"
    if row.target is None or not measurement.comparable:
        return "stated"
    return "met" if row.target.met(measurement.value) else "missed"
