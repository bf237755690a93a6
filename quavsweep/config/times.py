"""The clock of a sweep: transient, duration, segments and batches rounded up to whole multiples of each other."""

from __future__ import annotations

import math

from quavsweep.clock import Clock
from quavsweep.config.place import Keys, Place
from quavsweep.config.schema import Config, IntegrateSection
from quavsweep.errors import ConfigError

MAX_STEPS = 2**53  # whole numbers beyond are not exact as floats
MAX_SEGMENTS = 10**5
BATCHES = 64  # batches in transient + duration, unless the config says how long one is
BATCHES_PER_SEGMENT = 4
MAX_TRIED = 4096  # lengths of a batch

DT: Keys = ("integrate", "dt")
TRANSIENT: Keys = ("integrate", "transient")
DURATION: Keys = ("integrate", "duration")
SEGMENT: Keys = ("integrate", "segment")
BATCH: Keys = ("measures", "lyapunov", "batch")
MAX_DURATION: Keys = ("effort", "max_duration")
BLOCK: Keys = ("measures", "lyapunov", "block")


def choose_clock(config: Config, place: Place, period_steps: int = 0) -> Clock:
    """Round all times up to whole blocks, batches and segments, and to whole periods of the forcing.

    Unless the config says how long a batch is, there are 64 to 256 of them, whichever number needs least rounding.
    The blocks of a period are a whole number, or the periods of a block, see `in_step`.
    """
    _check_times(config, place)
    section, measures = config.integrate, config.measures
    block = measures.block
    total = section.transient + section.duration
    least = max(1, period_steps // block)  # blocks in the shortest batch
    if measures.batch:
        lengths = range(whole(measures.batch, least * block * section.dt), 0, -1)[:1]
    elif section.segment and not measures.lyapunov:
        parts = whole(section.segment, least * block * section.dt)
        number = next(n for n in (BATCHES_PER_SEGMENT, 2, 1) if parts % n == 0)
        lengths = range(parts // number, 0, -1)[:1]
    else:
        longest = whole(min(total / BATCHES, section.segment or total), least * block * section.dt)
        lengths = range(longest, longest // 4, -1)[:MAX_TRIED]
    clocks = (_rounded(section, block, least * length, period_steps) for length in lengths)
    clock = min(clocks, key=lambda c: round((c.transient + c.duration) / total, 9))
    _check_clock(clock, config, place)
    return clock


def _check_times(config: Config, place: Place) -> None:
    """Refuse times that do not fit together: a step, block, batch or segment longer than the run, too many steps."""
    section, measures = config.integrate, config.measures
    total = section.transient + section.duration
    if section.dt > section.duration:
        raise _no_step(section, place)
    if not total / section.dt < MAX_STEPS:
        keys, length = _longest(section)
        what = f"{length:g} is more than 9e15 steps of {place.other(DT, keys)}"
        raise place.error(keys, what, "a longer step or a shorter run")
    stretches = {SEGMENT: section.segment, BATCH: measures.batch, BLOCK: measures.block * section.dt}
    for keys, stretch in stretches.items():
        if stretch and stretch > total * (1 + 1e-9):
            raise _too_long(keys, stretch, config, place)


def _no_step(section: IntegrateSection, place: Place) -> ConfigError:
    """Return the error of a step that is longer than the duration; if only the duration was overridden, that is it."""
    if place.line(DT) and not place.line(DURATION):
        what = f"{section.duration:g} is shorter than a step, {place.other(DT, DURATION)}"
        return place.error(DURATION, what, f"at least {section.dt:g}")
    what = f"a step of {section.dt:g} is longer than {place.other(DURATION, DT)}"
    return place.error(DT, what, f"at most {section.duration:g}")


def _too_long(keys: Keys, length: float, config: Config, place: Place) -> ConfigError:
    """Return the error of a stretch of time that is longer than the run; a default is blamed on the step."""
    section = config.integrate
    what = f"{length:g}"
    if keys == BLOCK:
        keys = keys if place.has(keys) else DT
        what = f"{config.measures.block} steps of {section.dt:g}, {place.other(DT if keys == BLOCK else BLOCK, keys)},"
    run = f"{place.other(TRANSIENT, keys)} + {place.other(DURATION, keys)}"
    end = section.transient + section.duration
    return place.error(keys, f"{what} is longer than {run}".replace(", is", ", are"), f"at most {end:g} in all")


def _check_clock(clock: Clock, config: Config, place: Place) -> None:
    """Refuse more looks than can be stored."""
    if clock.segments <= MAX_SEGMENTS and clock.steps <= MAX_STEPS:
        return
    keys, length = _longest(config.integrate)
    causes = [key for key in (SEGMENT, BATCH) if place.has(key)] or [DT]
    named = " and ".join(place.other(key, keys) for key in causes)
    what = f"{length:g} with {named} makes {clock.segments} segments and {clock.steps:.3g} steps"
    raise place.error(keys, what, f"at most {MAX_SEGMENTS} segments; longer segments or batches make fewer")


def check_effort(config: Config, clock: Clock, place: Place) -> None:
    """Refuse an effort that is less than the run itself, or more than can be stored, or without checkpoints.

    Raises
    ------
    ConfigError
        For it, or for its `max_duration`.
    """
    if config.effort is None:
        return
    if config.evidence != "full":
        what = f"needs evidence: full, but {place.other(('evidence',), ('effort',))} is {config.evidence}"
        raise place.error(("effort",), what, "cells go on from checkpoints, which only full evidence has")
    most, segment = config.effort.max_duration, clock.segment_steps * clock.dt
    if most < clock.duration * (1 - 1e-9):
        what = f"{most:g} is shorter than {place.other(DURATION, MAX_DURATION)}"
        raise place.error(MAX_DURATION, what, f"at least {clock.duration:g}, or no effort")
    if clock.transient_segments + most / segment > MAX_SEGMENTS:
        what = f"{most:g} makes {most / segment:.3g} segments of {segment:g}"
        raise place.error(MAX_DURATION, what, f"at most {MAX_SEGMENTS} segments; longer ones make fewer")


def _longest(section: IntegrateSection) -> tuple[Keys, float]:
    """Return key and length of the longer part of the run."""
    parts: list[tuple[Keys, float]] = [(DURATION, section.duration), (TRANSIENT, section.transient)]
    return max(parts, key=lambda part: part[1])


def _rounded(section: IntegrateSection, block: int, batch_blocks: int, period_steps: int) -> Clock:
    """Return the clock with batches of so many blocks."""
    batch = batch_blocks * block * section.dt
    segment_batches = whole(section.segment, batch) if section.segment else BATCHES_PER_SEGMENT
    segment = segment_batches * batch
    transient = whole(section.transient, segment) if section.transient else 0
    segments = transient + whole(section.duration, segment)
    return Clock(section.dt, block, batch_blocks, segment_batches, transient, segments, period_steps)


def rounding(section: IntegrateSection, clock: Clock) -> tuple[str, ...]:
    """Return a sentence if times had to be changed."""
    used = {"transient": clock.transient, "duration": clock.duration}
    changed = [
        f"{key} {getattr(section, key):g} -> {t:g}" for key, t in used.items() if t > getattr(section, key) * (1 + 1e-9)
    ]
    whole = f"whole segments of {clock.segment_steps * clock.dt:g}"
    return (f"rounded up to {whole}: {', '.join(changed)}",) if changed else ()


def whole(length: float, unit: float) -> int:
    """Return the number of units that cover a length; rounding errors do not add one."""
    return max(1, math.ceil(length / unit * (1 - 1e-12) - 1e-9))
