"""A fault: how it is made, and what became of each case."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from tests.faults.arena import Arena


class NotRunError(Exception):
    """What a fault needs is not to be had here; its cases are reported as not run."""


@dataclass(frozen=True)
class Case:
    """What became of one case.

    Parameters
    ----------
    survived : bool
        Whether what is promised held.
    note : str
        What happened instead.
    silent : bool
        Whether something wrong was taken for right without a word.
    kinds : tuple of str
        What the case was, for the counts per kind.
    """

    survived: bool
    note: str = ""
    silent: bool = False
    kinds: tuple[str, ...] = ()


@dataclass(frozen=True)
class Fault:
    """A fault that is made again and again.

    Parameters
    ----------
    key : str
        As `F01`.
    title : str
    push, demand : int
        Number of cases by every run of the tests, 0 if they make none, and by `python -m tests.faults`.
    attack : callable
        Takes the arena and a number of cases and yields about so many.
    whole : callable
        Takes the cases of a kind and returns what is wrong with their counts, empty if nothing is.
    """

    key: str
    title: str
    push: int
    demand: int
    attack: Callable[[Arena, int], Iterator[Case]]
    whole: Callable[[Counter[str], int], str] = lambda kinds, cases: ""


@dataclass
class Tally:
    """The cases of a fault so far.

    Parameters
    ----------
    kinds : Counter
        Cases per kind.
    failures : list of str
        What happened in those that did not survive, the first hundred.
    whole : str
        What is wrong with all of them together.
    not_run : str
        Why there are none.
    """

    fault: Fault
    cases: int = 0
    survived: int = 0
    silent: int = 0
    kinds: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)
    whole: str = ""
    not_run: str = ""
    seconds: float = 0.0

    def add(self, case: Case) -> None:
        """Count a case."""
        self.cases += 1
        self.survived += case.survived and not case.silent
        self.silent += case.silent
        self.kinds.update(case.kinds)
        if (not case.survived or case.silent) and len(self.failures) < 100:
            self.failures.append(case.note or ", ".join(case.kinds))

    def count(self, cases: Iterable[Case]) -> Tally:
        """Count all of them, and judge their counts per kind."""
        try:
            for case in cases:
                self.add(case)
        except NotRunError as error:
            self.not_run = str(error)
        else:
            self.whole = self.fault.whole(self.kinds, self.cases)
        return self

    @property
    def holds(self) -> bool:
        """Whether cases were run and what is promised held in each."""
        return self.cases == self.survived and self.cases > 0 and not (self.silent or self.whole or self.not_run)
