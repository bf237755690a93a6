"""How a run's progress is shown: a bar on a terminal, a line every half minute otherwise."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator

from quavsweep.sweep import Progress

INTERVAL = 30.0  # s between two lines where there is no terminal


@contextlib.contextmanager
def show_progress(name: str) -> Iterator[Callable[[Progress], None]]:
    """Yield the observer of a run; it writes to standard error."""
    if sys.stderr is None or sys.stderr.closed:
        yield lambda progress: None
    elif sys.stderr.isatty():
        yield from _bar(name)
    else:
        yield _lines(name)


def _lines(name: str) -> Callable[[Progress], None]:
    last = time.monotonic()

    def observe(progress: Progress) -> None:
        nonlocal last
        finished = progress.tiles_done == progress.tiles
        if finished or time.monotonic() - last >= INTERVAL:
            last = time.monotonic()
            text = f"{name}: {progress.tiles_done}/{progress.tiles} tiles, {progress.cells_done}/{progress.cells} cells"
            with contextlib.suppress(OSError, ValueError):
                print(text + _speed(progress), file=sys.stderr, flush=True)

    return observe


def _bar(name: str) -> Iterator[Callable[[Progress], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, TaskID, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        TextColumn("{task.completed:.0f}/{task.total:.0f} cells{task.fields[speed]}"),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task: TaskID | None = None

        def observe(progress: Progress) -> None:
            nonlocal task
            if task is None:
                task = bar.add_task(name, total=progress.cells, speed="")
            bar.update(task, completed=progress.cells_done, total=progress.cells, speed=_speed(progress))

        yield observe


def _speed(progress: Progress) -> str:
    seconds = time.monotonic() - progress.started
    return f", {progress.cells_run / seconds:.0f} cells/s" if progress.cells_run and seconds > 0 else ""
