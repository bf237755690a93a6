"""What a margin found in words, the same in the terminal and in the paper's report."""

from __future__ import annotations

import math

from quavsweep.margin.criterion import Answer
from quavsweep.margin.finding import Gain, Line, Side

SIGNS = (
    "a distance is a size, and `to` says what it is to: tumbling, or safety where the craft tumbles at the base point "
    "of the line; a change is that of the parameter, with its sign; a margin is the distance to tumbling, or less "
    "the distance to safety, so that a gain above 0 is one in safety"
)


def answer_words(answer: Answer, brief: bool = False) -> str:
    """Return what was found at a point: the share of starts with its binomial error, the angle, or the region."""
    numbers = answer.numbers
    if "share" in numbers:
        return f"{100 * numbers['share']:.1f} +- {100 * numbers['share_se']:.1f} %"
    if answer.what == "lost" or not all(map(math.isfinite, numbers.values())):
        return answer.what
    if "peak_degrees" in numbers:
        return f"{numbers['peak_degrees']:.1f} deg" + ("" if brief else f" at {numbers['peak_time']:.4g} s")
    return answer.what.replace("quasi_periodic", "torus")


def state_words(line: Line) -> str:
    """Return whether the craft tumbles at the base point of a line, and what was found there."""
    answer = line.base.answer
    share = " of the starts do not end in a sink" if "share" in answer.numbers else ""
    return f"{'tumbles' if answer.tumbles else 'does not tumble'} ({answer_words(answer)}{share})"


def end_words(side: Side) -> str:
    """Return up to where there is no change one way, and what ends it."""
    why = f"ends at {side.way.ended_by}" if side.way.ended_by else "all of the reach"
    return f"none up to {side.way.direction.base + side.way.sign * side.way.limit:.4g}: {why}"


def value_words(line: Line, side: Side, most: int) -> tuple[str, str]:
    """Return the parameter at the safe run and at the tumbling one, so that they differ, in so many characters.

    Where the digits do not suffice they are told as what is added to the base value.
    """
    probes = [probe for probe in (side.inner, side.outer) if probe is not None]
    safe, tumbles = (probe.values[line.direction.along] for probe in sorted(probes, key=lambda p: p.answer.tumbles))
    for digits in range(6, 17):
        texts = f"{safe:.{digits}g}", f"{tumbles:.{digits}g}"
        if texts[0] != texts[1] and max(map(len, texts)) <= most:
            return texts
    base = line.direction.base
    first, second = ("base" if value == base else f"base{value - base:+.3g}" for value in (safe, tumbles))
    return first, second


def span_words(line: Line, unit: str) -> str:
    """Return from where to where a line has no change."""
    low, high = line.span
    ends = dict.fromkeys(side.way.ended_by for side in line.sides if side.way.ended_by)
    why = f" (the model ends: {', '.join(ends)})" if ends else ""
    return f"none from {low:.4g} to {high:.4g}{'' if unit == '1' else ' ' + unit}{why}"


def bound_words(side: Side) -> str:
    """Return why a distance is only a bound, empty if it is not."""
    if not side.bound or side.distance is None:
        return ""
    spacings = side.distance / math.ulp(side.way.direction.base)
    numbers = f", {spacings:.0f} spacings of the numbers there" if spacings < 1e6 else ""
    return f"a bound: the answer still changes at this distance{numbers}, too near for runs at 0.99 and 1.01 of it"


def unknown_words(gain: Gain, unit: str) -> str:
    """Return why a gain is not known, empty if it is."""
    if not gain.enters or math.isfinite(gain.per_percent):
        return ""
    if gain.bound:
        return "not known: a distance is only a bound"
    if gain.below is None or gain.above is None:
        return "not known: no such craft is possible"
    line = gain.lacking
    if line is None:
        return "not known"
    low, high = line.span
    return f"no change from {low:.4g} to {high:.4g}{'' if unit == '1' else ' ' + unit}"
