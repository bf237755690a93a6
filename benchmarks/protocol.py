"""The protocol of every measurement: interleaved samples of a few contenders, and ratios pair by pair."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

Samples = dict[str, list[float]]

TURN = 0.05  # s, after which the next contender goes on


class MissingError(Exception):
    """Something that a row needs is not installed; the message says what."""


@dataclass(frozen=True)
class Protocol:
    """How much is measured.

    Parameters
    ----------
    samples : int
        Samples per contender.
    seconds : float
        Least length of a sample [s].
    quick : bool
        Whether sweeps are thumbnails.
    """

    samples: int = 5
    seconds: float = 2.0
    quick: bool = False


FULL = Protocol()
QUICK = Protocol(samples=3, seconds=0.2, quick=True)


@dataclass(frozen=True)
class Contender:
    """One side of a comparison.

    Parameters
    ----------
    name : str
        What the table and the JSON call it.
    call : callable
        Does a fixed amount of work; whatever it compiles is compiled by its first call or before.
    work : float
        Units of work per call, e.g. steps x cells.
    once : bool
        Whether a sample is a single call, long enough by itself and not called to warm up.
    """

    name: str
    call: Callable[[], object]
    work: float
    once: bool = False

    def seconds(self, times: int) -> float:
        """Call it so many times and return how long that took [s]."""
        began = time.perf_counter()
        for _ in range(times):
            self.call()
        return time.perf_counter() - began

    def repetitions(self, seconds: float) -> int:
        """Return how many calls last about so long, after warming up."""
        if self.once:
            return 1
        self.call()
        times = 1
        while (took := self.seconds(times)) < 0.5 * seconds:
            times *= 2
        return max(1, round(times * seconds / took))


def compare(contenders: Sequence[Contender], protocol: Protocol) -> Samples:
    """Return the times per unit of work [ns] of the contenders' samples, taken in turn: A B A B ...

    Contenders take turns of `TURN` within their samples too, so that whatever else the machine does falls on all sides
    alike; whole runs do not.
    """
    whole = any(contender.once for contender in contenders)
    times = [contender.repetitions(protocol.seconds if whole else TURN) for contender in contenders]
    samples: Samples = {contender.name: [] for contender in contenders}
    for _ in range(protocol.samples):
        took = [0.0] * len(contenders)
        turns = 0
        while not turns or (not whole and min(took) < protocol.seconds):
            for i, contender in enumerate(contenders):
                took[i] += contender.seconds(times[i])
            turns += 1
        for contender, n, total in zip(contenders, times, took, strict=True):
            samples[contender.name].append(total / (turns * n * contender.work) * 1e9)
    return samples


def ratios(samples: Samples, above: str, below: str) -> list[float]:
    """Return the ratios of the samples that were taken side by side."""
    return [a / b for a, b in zip(samples[above], samples[below], strict=True)]
