"""Margins: the two runs of every change, read from `margin.json` and run again one by one, without what found them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep import Sweep, load_sweep
from quavsweep.codes import REGION, Region, Status
from quavsweep.margin import find_margin, write_margin
from quavsweep.point import compute_point
from tests.truth.laboratory import Laboratory, described
from tests.truth.row import Claim, Row

CONFIGS = Path(__file__).parents[2] / "configs" / "paper"
REGIONS = ("margin_case_1", "margin_case_2")  # in the third there is no change within reach
FLIGHTS = ("margin_flight_1", "margin_flight_2", "margin_flight_3")
DEGREES, WITHIN = 60.0, 20.0
LOST = (Status.DIVERGED, Status.LEFT_DOMAIN)
SHARES = {"inner": 0.99, "outer": 1.01}
SAME = 1e-9  # of the distance, by which a run may lie off its share of it, beside the spacing of the numbers
POINTS = 20  # of a quick scan


@dataclass(frozen=True)
class End:
    """One end of a bracket, as `margin.json` has it: where it lies, what is meant, what was said, if it is there."""

    where: str
    values: Mapping[str, float]
    tumbles: bool
    said: Mapping[str, Any]
    placed: bool

    @classmethod
    def all_of(cls, data: Mapping[str, Any]) -> Iterator[End]:
        """Yield the ends of the brackets of a margin; of a bound its outer one, which is all that it claims."""
        for line in data["directions"]:
            for side in line["sides"]:
                if side["distance"] is None:
                    continue
                for name in ("outer",) if side["bound_only"] else SHARES:
                    end = side[name]
                    meant = side["distance"] * (1.0 if side["bound_only"] else SHARES[name])
                    off = abs(abs(end["at"][line["along"]] - line["base"]) - meant)
                    placed = off <= math.ulp(line["base"]) + SAME * side["distance"]
                    tumbles = (line["to"] == "tumbling") == (name == "outer")
                    where = f"{line['direction']} {side['change']:+.4g}, {name}"
                    yield cls(where, end["at"], tumbles, end, placed)


def region(laboratory: Laboratory) -> list[Claim]:
    """Run the brackets by region again: only a sink does not tumble."""
    return [_again(laboratory, name, "region") for name in REGIONS]


def angle(laboratory: Laboratory) -> list[Claim]:
    """Run the brackets by angle again: the largest roll angle of the flight."""
    return [_again(laboratory, name, "angle") for name in FLIGHTS]


def _again(laboratory: Laboratory, name: str, by: str) -> Claim:
    sweep = load_sweep(CONFIGS / f"{name}.yaml")
    points = laboratory.choose(None, POINTS)
    found = find_margin(sweep, by, out=laboratory.path(f"{name}-{by}"), points=points, workers=laboratory.workers)
    data = json.loads(write_margin(found).read_text("utf-8"))
    bounds = sum(side["bound_only"] for line in data["directions"] for side in line["sides"])
    ends = list(End.all_of(data))
    wrong = []
    for end in ends:
        tumbles, what = _run(sweep, end.values, by)
        if not (tumbles == end.tumbles == end.said["tumbles"] and end.placed):
            wrong.append(f"{end.where}: {what}, said {end.said['what']}" + ("" if end.placed else ", elsewhere"))
    asked = f"{name} by {by}: the runs at 0.99 d and 1.01 d of every change, alone, show it"
    measured = "; ".join([f"{len(ends) - len(wrong)} of {len(ends)} runs do, {bounds} of bounds", *wrong])
    numbers = {"runs": len(ends), "wrong": wrong, "bounds": bounds}
    return Claim(asked, measured, bool(ends) and not wrong, described(sweep), numbers)


def _run(sweep: Sweep, values: Mapping[str, float], by: str) -> tuple[bool, str]:
    """Run one craft alone, and return whether it tumbles, and what it does."""
    point = compute_point(sweep, values)
    if by == "region":
        number = int(point.values["region"])
        return number != Region.SINK, REGION[number].name
    roll = point.orbit[point.time <= WITHIN + 1e-9, sweep.model.state_names.index("phi")]
    largest = float(np.degrees(np.abs(roll).max()))
    return largest > DEGREES or int(point.values["status"]) in LOST, f"{largest:.2f} deg"


ROWS = (
    Row("margin-region", "the runs that show margins by region, alone", "1 min", region),
    Row("margin-angle", "the runs that show margins by angle, alone", "1 min", angle),
)
