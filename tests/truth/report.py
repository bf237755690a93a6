"""The outcomes as text, as they come, and as JSON with all numbers."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from benchmarks.machine import describe
from tests.truth.row import Claim, Outcome

WIDTH = 120


def told(outcome: Outcome) -> str:
    """Return a row in words: what was asked, what was measured, the verdict, and the seconds it took."""
    verdict = "holds" if outcome.holds else "MISSED"
    lines = [f"{outcome.row.key}: {outcome.row.title}: {verdict}, {outcome.seconds:.1f} s"]
    setting = ""
    for claim in outcome.claims:
        if claim.setting != setting:
            lines += _wrapped(claim.setting, "  ")
            setting = claim.setting
        lines += _wrapped(f"{claim.verdict:6} {claim.asked} | {claim.measured}", "    ")
    if outcome.error:
        lines += _wrapped(f"MISSED {outcome.error}", "    ")
    return "\n".join(lines)


def _wrapped(text: str, indent: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent + "       ")


def summed_up(outcomes: Sequence[Outcome]) -> str:
    """Return how many rows hold, and which do not."""
    missed = [outcome.row.key for outcome in outcomes if not outcome.holds]
    seconds = sum(outcome.seconds for outcome in outcomes)
    which = f"; missed: {', '.join(missed)}" if missed else ""
    return f"{len(outcomes) - len(missed)} of {len(outcomes)} rows hold, {seconds:.0f} s{which}"


def record(outcomes: Sequence[Outcome], quick: bool) -> dict[str, Any]:
    """Return everything as data: machine, versions, commit, and all numbers of every row."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": describe(),
        "quick": quick,
        "rows": [
            {
                "key": outcome.row.key,
                "title": outcome.row.title,
                "holds": outcome.holds,
                "seconds": outcome.seconds,
                "error": outcome.error,
                "claims": [_claim(claim) for claim in outcome.claims],
            }
            for outcome in outcomes
        ],
    }


def _claim(claim: Claim) -> dict[str, Any]:
    return {
        "asked": claim.asked,
        "measured": claim.measured,
        "verdict": claim.verdict,
        "setting": claim.setting,
        "numbers": plain(claim.numbers),
    }


def plain(value: Any) -> Any:
    """Return a value made of what JSON knows; what is not finite becomes None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, complex):
        return [value.real, value.imag]
    return None if isinstance(value, float) and not np.isfinite(value) else value
