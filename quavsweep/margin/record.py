"""A margin as data for other programs, `margin.json`: the same bytes for any history of stops."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from quavsweep.margin.finding import Gain, Line, Margin, Probe, Side
from quavsweep.margin.word import SIGNS, bound_words, unknown_words
from quavsweep.whole import publish_bytes

NAME = "margin.json"


def write_margin(margin: Margin) -> Path:
    """Write `margin.json` beside the runs of a margin and return its path."""
    path = margin.folder / NAME
    publish_bytes(path, (json.dumps(margin_data(margin), indent=1, allow_nan=False) + "\n").encode())
    return path


def margin_data(margin: Margin) -> dict[str, Any]:
    """Return a margin as mappings, lists, texts and finite numbers."""
    model, unit = margin.sweep.model, margin.unit(margin.leading)
    return {
        "name": margin.sweep.name,
        "model": model.name,
        "by": margin.by,
        "tumbles": margin.criterion,
        "parameters": dict(margin.craft),
        "initial": dict(margin.initial),
        "notes": list(margin.notes),
        "reach": margin.reach,
        "signs": SIGNS,
        "directions": [_line(line, margin.unit(line)) for line in margin.lines],
        "do_not_enter": list(margin.absent),
        "gains": {
            "of": margin.leading.direction.name,
            "base": None if margin.leading_for_gains is None else _line(margin.leading_for_gains, unit),
            "per_percent": [_gain(gain, unit) for gain in margin.gains],
        },
        "runs": [
            {"folder": f"probe-{n}", "result_id": result_id, "points": points}
            for n, (result_id, points) in enumerate(margin.runs, 1)
        ],
    }


def _line(line: Line, unit: str) -> dict[str, Any]:
    direction = line.direction
    return {
        "direction": direction.name,
        "along": direction.along,
        "unit": unit,
        "base": direction.base,
        "base_probe": _probe(line.base),
        "to": line.to,
        "distance": line.distance,
        "relative": None if line.distance is None else line.distance / direction.scale,
        "margin": line.margin,
        "change": None if line.nearest is None else line.nearest.change,
        "bound_only": line.bound,
        "sides": [_side(side) for side in line.sides],
    }


def _side(side: Side) -> dict[str, Any]:
    return {
        "sign": side.way.sign,
        "limit": side.way.limit,
        "ended_by": side.way.ended_by or None,
        "spacing": side.way.spacing,
        "distance": side.distance,
        "change": side.change,
        "bound_only": side.bound,
        "bound_because": bound_words(side) or None,
        "inner": None if side.inner is None else _probe(side.inner),
        "outer": None if side.outer is None else _probe(side.outer),
        "scan": [{"distance": distance, "what": probe.answer.what, **_numbers(probe)} for distance, probe in side.scan],
    }


def _probe(probe: Probe) -> dict[str, Any]:
    answer = probe.answer
    found = {"tumbles": answer.tumbles, "what": answer.what, **_numbers(probe)}
    return {"at": dict(probe.values), **found, "run": probe.run, "result_id": probe.result_id}


def _numbers(probe: Probe) -> dict[str, float | None]:
    return {name: _finite(value) for name, value in probe.answer.numbers.items()}


def _gain(gain: Gain, unit: str) -> dict[str, Any]:
    changed = {"at_less": gain.below, "at_more": gain.above}
    return {
        "parameter": gain.name,
        "enters": gain.enters,
        "gain": _finite(gain.per_percent),
        "from_less": _finite(gain.from_below),
        "from_more": _finite(gain.from_above),
        "rough": gain.rough,
        "not_known_because": unknown_words(gain, unit) or None,
        **{key: None if line is None else _line(line, unit) for key, line in changed.items()},
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
