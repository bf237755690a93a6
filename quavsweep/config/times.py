"""The clock of a sweep: transient, duration, segments and batches rounded up to whole multiples of each other."""

from __future__ import annotations

import math

from quavsweep.clock import Clock
from quavsweep.config.document import Place
from quavsweep.config.schema import Config, IntegrateSection

MAX_SEGMENTS = 10**5
BATCHES = 64  # batches in transient + duration, unless the config says how long one is
BATCHES_PER_SEGMENT = 4
MAX_TRIED = 4096  # lengths of a batch


def choose_clock(config: Config, place: Place) -> Clock:
    """Round all times up to whole blocks, batches and segments.

    Unless the config says how long a batch is, there are 64 to 256 of them, whichever number needs least rounding.
    """
    section, measures = config.integrate, config.measures
    if section.dt > section.duration:
        raise place.error(("integrate", "dt"), f"a step of {section.dt:g} is longer than the duration")
    block = measures.block
    total = section.transient + section.duration
    asked = measures.batch or (None if measures.lyapunov else section.segment)
    for length in (total, asked or 0.0, section.segment or 0.0):
        if not length / section.dt < 2**53:
            raise place.error(("integrate",), f"{length / section.dt:.3g} steps are too many", "at most 9e15")
    if asked:
        lengths = range(_whole(asked, block * section.dt), 0, -1)[:1]
    else:
        longest = _whole(min(total / BATCHES, section.segment or total), block * section.dt)
        lengths = range(longest, longest // 4, -1)[:MAX_TRIED]
    clocks = (_rounded(section, block, batch_blocks) for batch_blocks in lengths)
    clock = min(clocks, key=lambda c: round((c.transient + c.duration) / total, 9))
    if clock.segments > MAX_SEGMENTS or clock.steps > 2**53:
        raise place.error(
            ("integrate", "duration"),
            f"{clock.segments} looks and {clock.steps:.3g} steps are too many",
            f"at most {MAX_SEGMENTS} segments; a longer segment or batch makes fewer",
        )
    return clock


def _rounded(section: IntegrateSection, block: int, batch_blocks: int) -> Clock:
    """Return the clock with batches of so many blocks."""
    batch = batch_blocks * block * section.dt
    segment_batches = _whole(section.segment, batch) if section.segment else BATCHES_PER_SEGMENT
    segment = segment_batches * batch
    transient = _whole(section.transient, segment) if section.transient else 0
    return Clock(
        section.dt, block, batch_blocks, segment_batches, transient, transient + _whole(section.duration, segment)
    )


def rounding(section: IntegrateSection, clock: Clock) -> tuple[str, ...]:
    """Return a sentence if times had to be changed."""
    used = {"transient": clock.transient, "duration": clock.duration}
    changed = [
        f"{key} {getattr(section, key):g} -> {t:g}" for key, t in used.items() if t > getattr(section, key) * (1 + 1e-9)
    ]
    whole = f"whole segments of {clock.segment_steps * clock.dt:g}"
    return (f"rounded up to {whole}: {', '.join(changed)}",) if changed else ()


def _whole(length: float, unit: float) -> int:
    """Return the number of units that cover a length; rounding errors do not add one."""
    return max(1, math.ceil(length / unit * (1 - 1e-12) - 1e-9))
