"""How far a run is: what it has done, what it found so far, and how long the rest will take."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from quavsweep.codes import REGION
from quavsweep.step_check import StepError


@dataclass
class Progress:
    """How far a run is; updated in place and handed to the observer after each tile.

    Parameters
    ----------
    tiles, cells : int
        Of the sweep.
    tiles_done, cells_done : int
        Covered by shards, of this run or earlier ones.
    cells_run, steps_run : int
        What this run has integrated: cells, and their steps, which early ends make fewer.
    failed : int
        Tiles that raised.
    regions : (regions,) int
        Cells of this run per region.
    stage : str
        `integrating` or `writing the result`.
    step_error : StepError, optional
        The error that the step causes, once it is known.
    """

    tiles: int
    cells: int
    tiles_done: int = 0
    cells_done: int = 0
    cells_run: int = 0
    steps_run: int = 0
    failed: int = 0
    regions: np.ndarray = field(default_factory=lambda: np.zeros(len(REGION), dtype=int))
    stage: str = "integrating"
    step_error: StepError | None = None
    started: float = field(default_factory=time.monotonic)

    def add(self, cells: int, steps: int, regions: np.ndarray) -> None:
        """Count a tile of this run."""
        self.tiles_done += 1
        self.cells_done += cells
        self.cells_run += cells
        self.steps_run += steps
        self.regions = self.regions + regions

    @property
    def seconds(self) -> float:
        """Time since the run began [s]."""
        return time.monotonic() - self.started

    @property
    def speed(self) -> float:
        """Cells per second of this run, 0 if there is none yet."""
        return self.cells_run / max(self.seconds, 1e-9)

    @property
    def seconds_left(self) -> float | None:
        """Estimated time until all tiles are done [s]; None as long as nothing is known.

        Tiles are done in an order that samples the grid evenly, so the cells left need as many steps on average as
        those that were done.
        """
        if not self.steps_run:
            return None
        steps_left = (self.cells - self.cells_done) * (self.steps_run / self.cells_run)
        return steps_left * self.seconds / self.steps_run
