"""How a run's progress is shown: a live bar on a terminal, a line every half minute otherwise."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from quavsweep.cli.text import duration, warn
from quavsweep.codes import REGION

if TYPE_CHECKING:
    from quavsweep.progress import Progress
    from quavsweep.step_check import StepError

INTERVAL = 30.0  # s between two lines where there is no terminal


class Shown:
    """The observer of a run; it writes to standard error.

    Attributes
    ----------
    cells_run : int
        Cells that this run has integrated so far.
    step_error : StepError or None
        The error that the step causes, once it is known.
    """

    def __init__(self, name: str) -> None:
        self.name, self.cells_run = name, 0
        self.step_error: StepError | None = None

    def __call__(self, progress: Progress) -> None:
        """Show how far the run is."""
        self.cells_run, self.step_error = progress.cells_run, progress.step_error
        self.show(progress)

    def show(self, progress: Progress) -> None:
        """Show it somewhere; here nowhere."""


class Lines(Shown):
    """A line every half minute."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._last = time.monotonic()

    def show(self, progress: Progress) -> None:
        """Print a line if it is time."""
        if time.monotonic() - self._last >= INTERVAL:
            self._last = time.monotonic()
            left = progress.seconds_left
            time_left = [f"{duration(left)} left"] if left else []
            warn("; ".join([f"{self.name}: {done(progress)}", *time_left, *details(progress)]))


class Bar(Shown):
    """A live bar, and below it what is known so far."""

    def __init__(self, name: str, bar: Any, live: Any) -> None:
        super().__init__(name)
        self._bar, self._live = bar, live
        self._task = bar.add_task(name, total=None, left="compiling")

    def show(self, progress: Progress) -> None:
        """Move the bar."""
        from rich.console import Group
        from rich.text import Text

        known = progress.seconds_left
        left = progress.stage if progress.stage != "integrating" else f"{duration(known)} left" if known else ""
        self._bar.update(self._task, completed=progress.cells_done, total=progress.cells, left=left)
        self._live.update(Group(self._bar, *(Text(f"  {line}") for line in [done(progress), *details(progress)])))


def done(progress: Progress) -> str:
    """Return how many tiles and cells are done, and how fast."""
    text = f"{progress.tiles_done}/{progress.tiles} tiles, {progress.cells_done:,}/{progress.cells:,} cells"
    return text + (f", {progress.speed:,.0f} cells/s" if progress.speed >= 1 else "")


def details(progress: Progress) -> list[str]:
    """Return shares of the regions so far, and failures, if there are any."""
    parts = []
    if progress.cells_run:
        shares = progress.regions / max(int(progress.regions.sum()), 1)
        found = [f"{code.meaning} {100 * share:.0f} %" for code, share in zip(REGION, shares, strict=True) if share]
        some = " (of this run's cells)" if progress.cells_done > progress.cells_run else ""
        parts.append(", ".join(found) + some)
    if progress.failed:
        parts.append(f"{progress.failed} tiles failed")
    return parts


@contextlib.contextmanager
def show_progress(name: str) -> Iterator[Shown]:
    """Show the progress of a run on standard error, as long as the context lasts.

    Use it as `with show_progress("name") as observe:` around `run_sweep(sweep, observe=observe)`.
    """
    if sys.stderr is None or sys.stderr.closed:
        yield Shown(name)
    elif sys.stderr.isatty():
        yield from _bar(name)
    else:
        yield Lines(name)


def _bar(name: str) -> Iterator[Bar]:
    from rich.console import Console
    from rich.live import Live
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        TaskProgressColumn(),
        TextColumn("{task.fields[left]}"),
    )
    bar = Progress(*columns, expand=True)
    with Live(bar, console=Console(stderr=True), transient=True) as live:
        yield Bar(name, bar, live)
