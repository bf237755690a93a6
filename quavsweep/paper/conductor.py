"""From nothing to the whole paper: runs, analyses, figures, a report; what fails is named, and the rest goes on."""

from __future__ import annotations

import json
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from quavsweep.errors import ConfigError, DiskError, IdentityError, LockedError, QuavsweepError, StoppedError
from quavsweep.paper.catalogue import ITEMS
from quavsweep.paper.item import Item
from quavsweep.paper.outcome import Outcome, analysed, heading
from quavsweep.paper.printed import read_printed
from quavsweep.paper.report import Entry, counts, write_report
from quavsweep.paper.row import Verdict
from quavsweep.paper.run import Runs, Show, unseen
from quavsweep.paper.thumbnail import CHANGES
from quavsweep.plot import save_figure
from quavsweep.plot.contact_sheet import make_contact_sheet
from quavsweep.plot.style import style
from quavsweep.whole import publish_bytes

MARK = "paper.json"  # by which a folder is known as one of the paper
FATAL = (StoppedError, IdentityError, LockedError, DiskError)  # what no other item could do better


@dataclass(frozen=True)
class Reproduction:
    """The paper, reproduced.

    Parameters
    ----------
    out : Path
        The folder of the report.
    outcomes : tuple of Outcome
        One per item that was done, in the paper's order.
    verdicts : dict
        How many rows of the report have each verdict, with those of items that were done earlier.
    """

    out: Path
    outcomes: tuple[Outcome, ...]
    verdicts: Mapping[Verdict, int]

    @property
    def failed(self) -> tuple[Outcome, ...]:
        """The items that failed."""
        return tuple(outcome for outcome in self.outcomes if outcome.error)


def reproduce_paper(
    out: Path | str | None = None,
    *,
    only: Sequence[str] = (),
    quick: bool = False,
    workers: int = 2,
    show: Show = unseen,
    tell: Callable[[str], None] = lambda line: None,
    stop: threading.Event | None = None,
) -> Reproduction:
    """Compute, check and draw the paper's figures and tables, or what is missing of them.

    Parameters
    ----------
    out : Path, optional
        Folder for runs, figures and report; default `results/paper`, `results/paper-quick` if quick.
    only : sequence of str
        The items to do; default all.
    quick : bool
        Whether to cut the grids to thumbnails, which take two minutes and show no more than that everything works.
    workers : int
        Number of threads.
    show, tell : callable
        Who watches a run, see `Runs`; who hears what is done.
    stop : threading.Event, optional
        Set it to stop; the same call continues.

    Raises
    ------
    ConfigError
        If there is no such item.
    IdentityError
        If the folder is not one of the paper, or holds runs of another engine.
    LockedError, DiskError, StoppedError
        As `run_sweep`.
    """
    out = Path(out if out is not None else "results/paper-quick" if quick else "results/paper")
    items = _chosen(only)
    _claim(out, quick)
    runs = Runs(out / "runs", workers, stop or threading.Event(), show, CHANGES if quick else {})
    outcomes, seconds = [], {}
    for item in items:
        tell(f"{item.name}: {item.title}")
        begin = time.monotonic()
        outcomes.append(_outcome(item, runs, out))
        seconds[item.name] = round(time.monotonic() - begin, 1)
        if outcomes[-1].error:
            tell(f"{item.name} failed: {outcomes[-1].error}")
        runs.forget()
    entries = write_report(out, outcomes, [item.name for item in ITEMS], quick)
    _draw_overview(out, entries)
    _publish(out / MARK, {"quick": quick, "seconds": seconds})
    return Reproduction(out, tuple(outcomes), counts(entries))


def _draw_overview(out: Path, entries: Sequence[Entry]) -> None:
    """Draw all figures small on one sheet."""
    pictures = [(heading(entry["item"]), out / entry["figure"]) for entry in entries if entry["figure"]]
    if pictures:
        with style():
            sheet = make_contact_sheet(pictures)
        save_figure(sheet, out / "figures" / "overview.png")


def _chosen(only: Sequence[str]) -> list[Item]:
    names = [item.name for item in ITEMS]
    for name in only:
        if name not in names:
            raise ConfigError(f"the paper has no {name} here", possible=", ".join(names))
    return [item for item in ITEMS if not only or item.name in only]


def _claim(out: Path, quick: bool) -> None:
    """Make the folder, or refuse one that is not the paper's."""
    mark = out / MARK
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        try:
            known = json.loads(mark.read_text("utf-8"))["quick"]
        except (OSError, ValueError, KeyError, TypeError):
            raise IdentityError("holds something else than the paper", str(out), "choose another --out") from None
        if known is not quick:
            other = "thumbnails" if known else "the whole paper"
            raise IdentityError(f"holds {other}", str(out), "choose another --out")
    _publish(mark, {"quick": quick})
    (out / "figures").mkdir(exist_ok=True)


def _publish(path: Path, data: Mapping[str, object]) -> None:
    publish_bytes(path, json.dumps(data, indent=1, sort_keys=True).encode() + b"\n")


def _outcome(item: Item, runs: Runs, out: Path) -> Outcome:
    """Return what becomes of an item."""
    printed = read_printed(item.name)
    try:
        findings = analysed(item, runs)
        ids = {name: str(runs[name].stored.file_attributes["result_id"]) for name in item.configs}
        figure = None
        if item.draw is not None:
            figure = Path("figures") / f"{item.name}.png"
            with style():
                drawn = item.draw(runs, findings)
            for suffix in (".pdf", ".png"):
                save_figure(drawn, (out / figure).with_suffix(suffix))
        (out / "failed" / f"{item.name}.txt").unlink(missing_ok=True)
        return Outcome(item, printed, findings, figure, ids)
    except FATAL:
        raise
    except Exception as error:
        what = str(error) if isinstance(error, QuavsweepError) else f"{type(error).__name__}: {error}"
        publish_bytes(out / "failed" / f"{item.name}.txt", traceback.format_exc().encode())
        return Outcome(item, printed, error=what)
