"""What a figure or table of the paper is here: configs, an analysis, a plot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Table:
    """A table of the report: texts, a row of names first."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Findings:
    """What an analysis found.

    Parameters
    ----------
    computed : mapping
        By key, a value for each row of `printed/<item>.yaml`; others are refused.
    data : any
        What the plot needs beside the runs.
    tables : sequence of Table
        For the report.
    text : str
        A few sentences for the report, made from what was computed.
    sources : mapping
        By the names of configs, the result ids of runs that the analysis itself made from them, by their folders.
    """

    computed: Mapping[str, Computed] = field(default_factory=dict)
    data: Any = None
    tables: Sequence[Table] = ()
    text: str = ""
    sources: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Item:
    """A figure or table of the paper, or a step beyond it.

    Parameters
    ----------
    name : str
        Of its files, as `figure_03`.
    title : str
        What the figure shows, for its caption.
    analyse : callable
        From the runs to what was found.
    draw : callable, optional
        From runs and findings to a figure; None of a table.
    configs : tuple of str
        The sweeps that it needs, by the names of files in `configs/paper`.
    """

    name: str
    title: str
    analyse: Callable[[Runs], Findings]
    draw: Callable[[Runs, Findings], Figure] | None = None
    configs: tuple[str, ...] = ()
