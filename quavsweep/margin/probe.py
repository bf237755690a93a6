"""Probes: points in parameter space that are run together as a sweep along one zipped axis, each of them once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from quavsweep.config import Sweep, dump_config, parse_sweep
from quavsweep.margin.criterion import Criterion
from quavsweep.margin.finding import Probe
from quavsweep.models import Model
from quavsweep.result import open_result

AXIS = "probe"
MOST = 4000  # points of a run, so that its config stays a text that can be read

Runner = Callable[[Sweep, Path], Path]


@dataclass
class Prober:
    """Runs points and remembers what was found.

    Parameters
    ----------
    data : dict
        Canonical config without axes and without the parameters that vary, as the criterion wants it.
    model : Model
    criterion : Criterion
    craft : mapping
        The values of the parameters that vary, at the base point.
    folder : Path
        Run n lies in its subfolder `probe-n`.
    run : callable
        Takes a sweep and a folder, returns the path of its result.
    """

    data: Mapping[str, Any]
    model: Model
    criterion: Criterion
    craft: Mapping[str, float]
    folder: Path
    run: Runner
    runs: list[tuple[str, int]] = field(default_factory=list)
    _known: dict[tuple[float, ...], Probe] = field(default_factory=dict)

    def at(self, changed: Mapping[str, float]) -> Probe:
        """Return what was found at a point that was asked about."""
        return self._known[self._key(changed)]

    def knows(self, changed: Mapping[str, float]) -> bool:
        """Whether a point was asked about."""
        return self._key(changed) in self._known

    def ask(self, points: Sequence[Mapping[str, float]]) -> None:
        """Run the points that are not known yet; each says what differs from the base craft."""
        new = [key for key in dict.fromkeys(map(self._key, points)) if key not in self._known]
        for start in range(0, len(new), MOST):
            self._run(new[start : start + MOST])

    def _run(self, keys: Sequence[tuple[float, ...]]) -> None:
        number = len(self.runs) + 1
        columns = {name: [key[i] for key in keys] for i, name in enumerate(self.craft)}
        axes = {AXIS: {"zip": columns}, **self.data["axes"]}
        sweep = parse_sweep(dump_config({**self.data, "axes": axes}), f"{AXIS}-{number}", model=self.model)
        result = open_result(self.run(sweep, self.folder / f"{AXIS}-{number}"))
        result_id = str(result.stored.file_attributes["result_id"])
        self.runs.append((result_id, len(keys)))
        for key, answer in zip(keys, self.criterion.read(result), strict=True):
            self._known[key] = Probe(dict(zip(self.craft, key, strict=True)), answer, number, result_id)

    def _key(self, changed: Mapping[str, float]) -> tuple[float, ...]:
        return tuple(float(changed.get(name, value)) for name, value in self.craft.items())
