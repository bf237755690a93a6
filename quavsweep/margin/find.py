"""From a sweep to the margin of its craft."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from quavsweep.config import Sweep
from quavsweep.errors import ConfigError
from quavsweep.margin.criterion import DEGREES, SHARE, WITHIN, make_criterion
from quavsweep.margin.direction import CRAFT, Direction, Domain, changed_parameters, directions_of, is_craft
from quavsweep.margin.finding import Margin
from quavsweep.margin.gain import STAGES, changed_crafts, find_gains
from quavsweep.margin.line import WAYS, find_lines
from quavsweep.margin.probe import Prober
from quavsweep.sweep import Observer, run_sweep

REACH = 0.5  # the default of how far to look
POINTS = {"region": 100, "basin": 50, "angle": 100}  # and with how many points each way
WHOLE = (1.0,)  # of a scan in one go


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
        what = f"a reach of {100 * reach:g} % with {points} points cannot be scanned"
        raise ConfigError(what, "margin", "a reach of more than 0 % and at most 10000 %, 1 to 10000 points")
    criterion = make_criterion(sweep, by, share, degrees, within)
    model, craft = sweep.model, {**sweep.model.defaults, **sweep.parameters}
    initial, notes = _start(sweep, by)
    data = criterion.prepare(_canonical(sweep, initial))
    domain = Domain(model, craft)
    directions = directions_of(model, craft)
    if not directions:
        raise ConfigError(f"{model.name} has no parameters", "margin", "a model with parameters")
    names = changed_parameters(model)
    changed = changed_crafts(craft, directions[0], names, domain)
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
    lines = find_lines(ways, [WHOLE] * whole + [STAGES] * (len(ways) - whole), prober)
    found = tuple(lines[: len(directions)])
    gains = find_gains(craft, names, (found[0], *lines[len(directions) :]), domain, reach, prober)
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
        gains=gains,
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


def _varied(directions: Sequence[Direction]) -> list[str]:
    """Return the parameters that some direction varies."""
    return list(dict.fromkeys(name for direction in directions for name in direction.values(0.0)))
