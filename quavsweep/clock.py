"""Clock: all lengths of time of a sweep in whole steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Clock:
    """All lengths of time in whole steps and whole multiples of each other.

    Parameters
    ----------
    dt : float
        Step, in the model's time.
    block : int
        Steps between two orthonormalisations.
    batch_blocks : int
        Blocks per batch, the window of an error bar.
    segment_batches : int
        Batches per segment, the stretch between two looks.
    transient_segments, segments : int
        Segments before averaging begins, and in all.
    period_steps : int
        Steps in a period of the forcing, of which batches have whole numbers; 0 where nothing is forced.
    """

    dt: float
    block: int
    batch_blocks: int
    segment_batches: int
    transient_segments: int
    segments: int
    period_steps: int = 0

    @property
    def batch_steps(self) -> int:
        """Steps per batch."""
        return self.block * self.batch_blocks

    @property
    def segment_steps(self) -> int:
        """Steps per segment."""
        return self.batch_steps * self.segment_batches

    @property
    def steps(self) -> int:
        """Steps in all."""
        return self.segment_steps * self.segments

    @property
    def transient_steps(self) -> int:
        """Steps before averaging begins."""
        return self.segment_steps * self.transient_segments

    @property
    def transient(self) -> float:
        """Time before averaging begins."""
        return self.transient_steps * self.dt

    @property
    def duration(self) -> float:
        """Time over which exponents are averaged."""
        return self.segment_steps * (self.segments - self.transient_segments) * self.dt

    def phase(self, steps: Any) -> Any:
        """Return the time since the forcing last began a period, after so many steps (a number or an array).

        A forced system depends on no other time; None where nothing is forced.
        """
        return steps % self.period_steps * self.dt if self.period_steps else None

    def steps_of(self, time: float) -> int:
        """Return the number of steps that comes nearest to a time."""
        return round(time / self.dt)
