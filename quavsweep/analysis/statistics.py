"""What the measure `statistics` writes down: sums over steps in one order, whatever lanes and tiles there are."""

from __future__ import annotations

import numpy as np

from quavsweep.analysis.event import crossings
from quavsweep.analysis.scene import Chunk, Scene, Watcher
from quavsweep.analysis.standard_error import noise_of
from quavsweep.measures import Statistics


class StatisticsWatcher(Watcher):
    """Keeps integrals over batches, extremes and changes of sign; makes means of them at the end."""

    def __init__(self, scene: Scene, statistics: Statistics) -> None:
        self._scene, self._first = scene, statistics.first(scene.clock)
        self._signals = [scene.signal(name) for name in statistics.of]
        self._last: list[np.ndarray] = []  # cells whose last step was seen

    def see(self, chunk: Chunk) -> None:
        """Add the steps of a chunk, which lies within a batch."""
        skipped = max(0, self._first - chunk.first)
        if chunk.first + skipped >= chunk.last:
            return
        evidence, cells, clock = self._scene.evidence, chunk.cells, self._scene.clock
        batch = chunk.first // clock.batch_steps
        begins = chunk.first + skipped == max(self._first, batch * clock.batch_steps)
        for column, signal in enumerate(self._signals):
            value = signal.of(chunk, self._scene, signal.value, skipped)
            # Added one after the other, because a sum's order would depend on how many cells there are.
            sums = np.add.accumulate(0.5 * (value[:-1] + value[1:]), axis=0)[-1]
            before = 0.0 if begins else evidence["statistic_sum"][cells, batch, column]
            evidence["statistic_sum"][cells, batch, column] = before + sums
            for name, extreme in (("statistic_min", np.fmin), ("statistic_max", np.fmax)):
                evidence[name][cells, column] = extreme(evidence[name][cells, column], extreme.reduce(value, axis=0))
            changes = crossings(value[:-1], value[1:], "both").sum(axis=0)
            evidence["sign_changes"][cells, column] += changes.astype(np.int32)
        if chunk.last == clock.steps:
            self._last.append(cells)

    def settle(self) -> None:
        """Write the means of cells that came to the end."""
        if not self._last:
            return
        evidence, clock, cells = self._scene.evidence, self._scene.clock, np.concatenate(self._last)
        self._last.clear()
        sums = evidence["statistic_sum"][cells, self._first // clock.batch_steps : clock.steps // clock.batch_steps]
        total = np.add.accumulate(sums, axis=1)[:, -1]
        evidence["statistic_mean"][cells] = total / (clock.steps - self._first)
        whole = sums[:, 1 if self._first % clock.batch_steps else 0 :].transpose(0, 2, 1) / clock.batch_steps
        evidence["statistic_mean_se"][cells] = noise_of(whole).error(max(1, whole.shape[-1]))

    def void(self, cells: np.ndarray, known: np.ndarray) -> None:
        """Leave no number where the orbit broke down."""
        cells = cells[known < self._scene.clock.steps]
        for name in ("statistic_sum", "statistic_mean", "statistic_mean_se", "statistic_min", "statistic_max"):
            self._scene.evidence[name][cells] = np.nan
        self._scene.evidence["sign_changes"][cells] = 0
