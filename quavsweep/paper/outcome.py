"""What became of a figure or table: its rows, its files, or the error that stopped it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from quavsweep.errors import QuavsweepError
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Printed, Row
from quavsweep.paper.run import Runs


@dataclass(frozen=True)
class Outcome:
    """An item after its turn.

    Parameters
    ----------
    item : Item
    printed : tuple of Printed
        What the paper says.
    findings : Findings
        What was computed; nothing where it failed.
    figure : Path, optional
        The picture, relative to the report.
    result_ids : dict
        Of the runs that it rests on, by the names of their configs.
    error : str
        What went wrong, empty if nothing did.
    """

    item: Item
    printed: tuple[Printed, ...]
    findings: Findings = field(default_factory=Findings)
    figure: Path | None = None
    result_ids: dict[str, str] = field(default_factory=dict)
    error: str = ""

    @property
    def rows(self) -> tuple[Row, ...]:
        """The paper's numbers beside the computed ones."""
        return tuple(Row(printed, self.findings.computed.get(printed.key)) for printed in self.printed)

    @property
    def source(self) -> str:
        """The configs and result ids that it rests on, in words."""
        named = [f"`{name}.yaml` (result {self.result_ids.get(name, 'missing')[:12]})" for name in self.item.configs]
        named += [f"`{name}.yaml` ({len(ids)} runs)" for name, ids in self.findings.sources.items()]
        ids = "; the result ids of these runs are in `report.json`" if self.findings.sources else ""
        return "Computed from " + ", ".join(named) + ids if named else "Computed without a sweep"

    @property
    def all_result_ids(self) -> dict[str, str]:
        """The result ids of all runs, also those that the analysis made, by their folders."""
        made = (ids for ids in self.findings.sources.values())
        return self.result_ids | {folder: result_id for ids in made for folder, result_id in ids.items()}


def analysed(item: Item, runs: Runs) -> Findings:
    """Return what the analysis of an item finds.

    Raises
    ------
    QuavsweepError
        If it computes other quantities than the paper's file names.
    """
    findings = item.analyse(runs)
    keys, known = set(findings.computed), {printed.key for printed in read_printed(item.name)}
    if keys != known:
        odd = ", ".join(sorted(keys ^ known))
        raise QuavsweepError(f"computed and printed quantities differ: {odd}", item.name)
    return findings


def heading(name: str) -> str:
    """Return what an item is called: `Figure 3` for `figure_03`."""
    words = name.replace("_", " ").split()
    return " ".join(str(int(word)) if word.isdigit() else word for word in words).capitalize()
