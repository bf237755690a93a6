"""From a sweep to the margin of its craft: lines are scanned and narrowed together, run by run."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from quavsweep.config import Sweep
from quavsweep.errors import ConfigError
from quavsweep.margin.criterion import DEGREES, SHARE, WITHIN, make_criterion
from quavsweep.margin.direction import CRAFT, Direction, Domain, Way, changed_parameters, directions_of, is_craft
from quavsweep.margin.finding import PERCENT, Gain, Line, Margin, Side
from quavsweep.margin.probe import Prober
from quavsweep.margin.search import Found, nearest_change, run_searches
from quavsweep.sweep import Observer, run_sweep

REACH = 0.5  # the default of how far to look
POINTS = {"region": 100, "basin": 50, "angle": 100}  # and with how many points each way
WHOLE, STAGES = (1.0,), (0.125, 0.25, 0.5, 1.0)  # a scan in one go, and one that ends at the first change
WAYS = (-1, 1)


def find_margin(
    sweep: Sweep,
    by: str = "region",
    *,
    out: Path | str | None = None,
    reach: float = REACH,
    points: int | None = None,
    share: float = SHARE,
    degrees: float = DEGREES,
    within: float = WITHIN,
    workers: int = 2,
    observe: Observer | None = None,
    stop: threading.Event | None = None,
) -> Margin:
    """Return how far a craft is from the nearest point where it tumbles, and what would take it farther away.

    Parameters
    ----------
    sweep : Sweep
        Its model, parameters, initial state and integration; axes are left out, but for the ensemble of `basin`.
    by : str
        `region`: the start does not end in a sink; `basin`: more than `share` of many starts do not; `angle`: the
        roll angle exceeds `degrees` within the time `within`.
    out : Path, optional
        Folder of the runs; default `results/<name>-margin/<by>`. What lies there is not run again.
    reach : float
        How far to look along each direction, as a share of the base value.
    points : int
        Points of the scan up to there, each way; default 100, by `basin` 50.
    workers, observe, stop
        See `run_sweep`.

    Raises
    ------
    ConfigError
        If the model has not what the criterion needs, or the options make no sense.
    IdentityError, LockedError, DiskError, StoppedError, TilesFailedError
        As `run_sweep`.
    """
    points = POINTS.get(by, 1) if points is None else points
    if not 0 < reach <= 100 or not 1 <= points <= 10_000:
        what = f"a reach of {reach:g} with {points} points cannot be scanned"
        raise ConfigError(what, "margin", "0 < reach <= 100, 1 to 10000 points")
    criterion = make_criterion(sweep, by, share, degrees, within)
    model, craft = sweep.model, {**sweep.model.defaults, **sweep.parameters}
    initial, notes = _start(sweep, by)
    data = criterion.prepare(_canonical(sweep, initial))
    domain = Domain(model, craft)
    directions = directions_of(model, craft)
    if not directions:
        raise ConfigError(f"{model.name} has no parameters", "margin", "a model with parameters")
    changed = _changed(craft, directions[0], changed_parameters(model), domain)
    varied = _varied((*directions, *changed))
    data["parameters"] = {name: value for name, value in craft.items() if name not in varied}
    folder = Path(out) if out is not None else sweep.folder.with_name(f"{sweep.name}-margin") / by
    prober = Prober(
        data,
        model,
        criterion,
        {name: craft[name] for name in varied},
        folder,
        lambda probes, path: run_sweep(probes, path, workers=workers, observe=observe, stop=stop),
    )
    ways = [domain.way(direction, sign, reach, points) for direction in (*directions, *changed) for sign in WAYS]
    whole = len(WAYS) * len(directions)
    lines = _lines(ways, [WHOLE] * whole + [STAGES] * (len(ways) - whole), prober)
    found = tuple(lines[: len(directions)])
    return Margin(
        sweep=sweep,
        by=by,
        criterion=criterion.text,
        craft=craft,
        initial=initial,
        notes=notes,
        reach=reach,
        lines=found,
        absent=tuple(name for name in CRAFT if name not in craft) if is_craft(model) else (),
        gains=_gains(craft, changed_parameters(model), found[0], lines[len(directions) :]),
        runs=tuple(prober.runs),
        folder=folder,
    )


def _start(sweep: Sweep, by: str) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the initial state, and notes of the axes that are left out and of the values used instead."""
    drawn = set(sweep.config.ensemble.box) if sweep.config.ensemble is not None else set()
    names = sweep.grid.quantities
    over = [name for name in names if name in sweep.model.parameter_names]
    notes = []
    if over:
        used = ", ".join(f"{name} = {sweep.model.defaults[name]:g}" for name in over)
        notes.append(f"the axes over {', '.join(over)} are left out: {used}, the model's defaults")
    missing = [name for name in sweep.model.state_names if name not in sweep.config.initial]
    needed = [name for name in missing if by != "basin" or name not in drawn]
    example = sweep.model.example.initial if sweep.model.example is not None else {}
    if unknown := [name for name in needed if name not in example]:
        raise ConfigError(f"there is no one start: {', '.join(unknown)} vary", sweep.name, "give initial in the config")
    if needed:
        used = ", ".join(f"{name} = {example[name]:g}" for name in needed)
        notes.append(f"the axes over {', '.join(needed)} are left out: {used}, the model's example")
    known = {**{name: example[name] for name in needed}, **sweep.config.initial}
    return {name: known[name] for name in sweep.model.state_names if name in known}, tuple(notes)


def _canonical(sweep: Sweep, initial: Mapping[str, float]) -> dict[str, Any]:
    """Return the canonical config without axes and figures."""
    data = {key: value for key, value in sweep.canonical().items() if key != "plot"}
    return {**data, "initial": dict(initial), "axes": {}}


def _changed(craft: Mapping[str, float], leading: Direction, names: Sequence[str], domain: Domain) -> list[Direction]:
    """Return the leading direction of the crafts that are possible with 1 % less or more of one parameter."""
    crafts = [{name: craft[name] * (1 + sign * PERCENT)} for name in names if name in craft for sign in WAYS]
    possible = [others for others in crafts if not domain.refusal(others)]
    return [Direction(leading.name, leading.along, leading.base, others) for others in possible]


def _gains(craft: Mapping[str, float], names: Sequence[str], base: Line, changed: Sequence[Line]) -> tuple[Gain, ...]:
    """Return the gain of each parameter, from the lines of the changed crafts."""
    gains = []
    for name in names:
        own = {line.direction.others[name] > craft[name]: line for line in changed if name in line.direction.others}
        gains.append(Gain(name, name in craft, own.get(False), own.get(True), base))
    return tuple(gains)


def _varied(directions: Sequence[Direction]) -> list[str]:
    """Return the parameters that some direction varies."""
    return list(dict.fromkeys(name for direction in directions for name in direction.values(0.0)))


def _lines(ways: Sequence[Way], stages: Sequence[Sequence[float]], prober: Prober) -> list[Line]:
    """Return what was found along directions, two ways each; `stages` are the shares of each scan, one by one."""
    searches = [nearest_change(_cut(way.scan, shares)) for way, shares in zip(ways, stages, strict=True)]

    def ask(questions: Sequence[tuple[int, np.ndarray]]) -> list[np.ndarray]:
        wanted = [[ways[number].point(distance) for distance in asked.tolist()] for number, asked in questions]
        prober.ask([point for points in wanted for point in points])
        return [np.array([prober.at(point).answer.tumbles for point in points]) for points in wanted]

    sides = [_side(way, found, prober) for way, found in zip(ways, run_searches(searches, ask), strict=True)]
    bases = [prober.at(way.point(0.0)) for way in ways[::2]]
    pairs = zip(bases, sides[::2], sides[1::2], strict=True)
    return [Line(below.way.direction, base, (below, above)) for base, below, above in pairs]


def _cut(scan: Sequence[float], shares: Sequence[float]) -> list[np.ndarray]:
    """Return the stages of a scan that end at some shares of it."""
    ends = [0, *(math.ceil(share * len(scan)) for share in shares)]
    return [np.asarray(scan[begin:end]) for begin, end in itertools.pairwise(ends)]


def _side(way: Way, found: Found, prober: Prober) -> Side:
    """Return what a search found, with the runs that show it."""
    inner, outer = (None if x is None else prober.at(way.point(x)) for x in (found.inner, found.outer))
    scan = tuple((x, prober.at(way.point(x))) for x in way.scan if prober.knows(way.point(x)))
    return Side(way, found.distance, inner, outer, scan)
