"""When a craft tumbles: by where one start ends, by the share of starts that end elsewhere, or by the roll angle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from quavsweep.analysis.lifetime import share_error
from quavsweep.codes import REGION, Region, Status
from quavsweep.config import Sweep
from quavsweep.errors import ConfigError
from quavsweep.reduction import KINDS
from quavsweep.result import Result

SHARE, DEGREES, WITHIN = 0.05, 60.0, 20.0  # the defaults of what counts as tumbling
ROLL = "phi"  # the state that is the roll angle [rad]
BOX = {"p": [-2.0, 2.0], "q": [-2.0, 2.0], "r": [-4.0, 6.0]}  # rad/s; starts, where a config draws none
STARTS, SEED = 64, 1
CRITERIA = ("region", "basin", "angle")


@dataclass(frozen=True)
class Answer:
    """What was found at a point.

    Parameters
    ----------
    tumbles : bool
    what : str
        The region of the orbit's end, or for many starts the most frequent one among those that count; by angle
        `within` or `beyond`, or how the orbit was lost.
    numbers : dict
        What decided, by name, such as `share` and `share_se`.
    """

    tumbles: bool
    what: str
    numbers: dict[str, float]


class Criterion(Protocol):
    """A way to tell whether a craft tumbles."""

    @property
    def text(self) -> str:
        """What tumbling means, in words."""

    def prepare(self, data: dict[str, Any]) -> dict[str, Any]:
        """Return the canonical config of a sweep without axes, with what this criterion needs to be computed."""

    def read(self, result: Result) -> list[Answer]:
        """Return what a sweep over points found."""


@dataclass(frozen=True)
class ByRegion:
    """A craft tumbles whose one start does not end in a sink within the run."""

    end: float
    unit: str

    @property
    def text(self) -> str:
        """What tumbling means, in words."""
        return f"the orbit of the start does not end in a sink within {self.end:g}{self.unit}"

    def prepare(self, data: dict[str, Any]) -> dict[str, Any]:
        """Keep the exponents, which tell chaos from cycles."""
        kept = {name: value for name, value in data["measures"].items() if name == "lyapunov"}
        return {**data, "measures": kept}

    def read(self, result: Result) -> list[Answer]:
        """Return the region of each point."""
        return [Answer(int(code) != Region.SINK, REGION[int(code)].name, {}) for code in result["region"]]


@dataclass(frozen=True)
class ByBasin:
    """A craft tumbles if more than a share of its starts do not end in a sink."""

    share: float
    ensemble: dict[str, Any]
    end: float
    unit: str

    @property
    def text(self) -> str:
        """What tumbling means, in words."""
        starts = f"{self.ensemble['num']} starts"
        return f"more than {100 * self.share:g} % of {starts} do not end in a sink within {self.end:g}{self.unit}"

    def prepare(self, data: dict[str, Any]) -> dict[str, Any]:
        """Follow an ensemble of starts instead of exponents."""
        fixed = {name: value for name, value in data["initial"].items() if name not in self.ensemble["box"]}
        rest = {key: value for key, value in data.items() if key != "effort"}
        return {**rest, "initial": fixed, "axes": {"ensemble": self.ensemble}, "measures": {}}

    def read(self, result: Result) -> list[Answer]:
        """Return the share of starts at each point that do not end in a sink, with its binomial error."""
        shares, starts = result["basin_share"], result["starts"]
        sink = next(i for i, kind in enumerate(KINDS) if kind.number == Region.SINK)
        others = [i for i in range(len(KINDS)) if i != sink]
        answers = []
        for share, total in zip(shares, starts, strict=True):
            count = round(float(1.0 - share[sink]) * int(total))
            tumbles = count > self.share * int(total)
            most = KINDS[max(others, key=lambda i: share[i])] if tumbles else KINDS[sink]
            error = float(share_error(np.array(count), np.array(total)))
            answers.append(Answer(tumbles, most.name, {"share": count / int(total), "share_se": error}))
        return answers


@dataclass(frozen=True)
class ByAngle:
    """A craft tumbles if its roll angle exceeds a limit within a time."""

    degrees: float
    within: float

    @property
    def text(self) -> str:
        """What tumbling means, in words."""
        return f"the roll angle exceeds {self.degrees:g} degrees within {self.within:g} s"

    def prepare(self, data: dict[str, Any]) -> dict[str, Any]:
        """Follow the start until that time, for its largest angle."""
        rest = {key: value for key, value in data.items() if key != "effort"}
        times = {k: v for k, v in data["integrate"].items() if k != "transient"}
        return {
            **rest,
            "integrate": {**times, "duration": self.within, "segment": self.within},
            "stop_early": False,  # no end is looked for
            "measures": {"peak": {"of": [ROLL], "until": self.within}},
        }

    def read(self, result: Result) -> list[Answer]:
        """Return the largest angle of each point and its time; an orbit that is lost before counts as tumbling."""
        peaks, times = result["peak"][:, 0], result["peak_time"][:, 0]
        answers = []
        for peak, time, status in zip(peaks, times, result["status"], strict=True):
            lost = int(status) in (Status.DIVERGED, Status.LEFT_DOMAIN)
            beyond = not math.degrees(abs(peak)) <= self.degrees
            what = "beyond" if beyond else "lost" if lost else "within"
            numbers = {"peak_degrees": math.degrees(peak), "peak_time": float(time)}
            answers.append(Answer(beyond or lost, what, numbers))
        return answers


def make_criterion(
    sweep: Sweep, by: str, share: float = SHARE, degrees: float = DEGREES, within: float = WITHIN
) -> Criterion:
    """Return the criterion of a name.

    Raises
    ------
    ConfigError
        If there is no such criterion, or the model has not what it needs.
    """
    names, unit = sweep.model.state_names, sweep.unit_of_time
    end = max(sweep.clock.steps, sweep.most_steps) * sweep.clock.dt
    if by == "region":
        return ByRegion(end, unit)
    if by == "basin":
        if not 0 <= share < 1:
            what = f"a share of {100 * share:g} % of the starts cannot be exceeded"
            raise ConfigError(what, f"margin by {by}", "at least 0 % and less than 100 %, such as 5 %")
        return ByBasin(share, _ensemble(sweep), sweep.clock.steps * sweep.clock.dt, unit)
    if by == "angle":
        if ROLL not in names:
            what = f"{sweep.model.name} has no roll angle {ROLL}; its states are {', '.join(names)}"
            raise ConfigError(what, f"margin by {by}", "model: quadrotor has it; region and basin need none")
        if not (0 < degrees < 180 and sweep.clock.dt <= within < math.inf):
            what = f"{degrees:g} degrees within {within:g}{unit} cannot be told"
            possible = f"more than 0 and less than 180 degrees, a finite time of at least a step, {sweep.clock.dt:g}"
            raise ConfigError(what, f"margin by {by}", f"{possible}{unit}")
        return ByAngle(degrees, within)
    raise ConfigError(f"there is no margin by {by}", possible=", ".join(CRITERIA))


def _ensemble(sweep: Sweep) -> dict[str, Any]:
    """Return the starts that the config draws, or the default ones of a craft."""
    drawn = sweep.config.ensemble
    if drawn is not None:
        return dict(drawn.model_dump(mode="json"))
    if not set(BOX) <= set(sweep.model.state_names):
        what = f"there is no default box of starts for {sweep.model.name}"
        raise ConfigError(what, "margin by basin", "give axes: {ensemble: {num, seed, box}} in the config")
    return {"num": STARTS, "seed": SEED, "box": {name: list(interval) for name, interval in BOX.items()}}
