"""The sweeps of the paper: configs that come with the package, run where they are first asked for."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path

from quavsweep.config import Sweep, load_sweep
from quavsweep.errors import ConfigError
from quavsweep.progress import Progress
from quavsweep.result import Result, open_result
from quavsweep.sweep import run_sweep

HERE = Path(__file__).parent
PLACES = (HERE / "configs", HERE.parent.parent / "configs" / "paper")  # of an installation, and of a source tree

Observer = Callable[[Progress], None]
Show = Callable[[str], AbstractContextManager[Observer]]  # from a sweep's name to who watches it


def config_path(name: str) -> Path:
    """Return the config of a sweep of the paper.

    Raises
    ------
    ConfigError
        If there is none of that name.
    """
    for place in PLACES:
        if (path := place / f"{name}.yaml").is_file():
            return path
    names = sorted(path.stem for place in PLACES for path in place.glob("*.yaml"))
    raise ConfigError(f"the paper has no config {name}", possible=", ".join(names))


def unseen(name: str) -> AbstractContextManager[Observer]:
    """Watch nothing."""
    return contextlib.nullcontext(lambda progress: None)


@dataclass
class Runs:
    """The runs of the paper's sweeps in a folder; each is made, or completed, where its result is first asked for.

    Parameters
    ----------
    out : Path
        Folder of the folders of the runs.
    workers : int
    stop : threading.Event
        Stops the run that is going on.
    show : callable
        Gives, for the name of a sweep, who watches its progress.
    changes : mapping
        From a sweep's name to what differs from its config, as `axes.c.num=41`.
    """

    out: Path
    workers: int = 2
    stop: threading.Event = field(default_factory=threading.Event)
    show: Show = unseen
    changes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    _results: dict[tuple[str, float | None], Result] = field(default_factory=dict)

    def sweep(self, name: str) -> Sweep:
        """Return a sweep of the paper by the name of its config."""
        return load_sweep(config_path(name), tuple(self.changes.get(name, ())))

    def folder(self, name: str) -> Path:
        """Return the folder of a run."""
        return self.out / name

    def result(self, name: str, horizon: float | None = None) -> Result:
        """Return the result of a sweep, at its end or at a horizon, in the sweep's time; what is missing is run."""
        key = name, horizon
        if key not in self._results:
            if not any(name == known for known, _ in self._results):
                with self.show(name) as observe:
                    run_sweep(
                        self.sweep(name), self.folder(name), workers=self.workers, observe=observe, stop=self.stop
                    )
            self._results[key] = open_result(self.folder(name), horizon)
        return self._results[key]

    def __getitem__(self, name: str) -> Result:
        return self.result(name)

    def forget(self) -> None:
        """Let go of the results, so that their memory is free."""
        self._results.clear()
