"""The sweeps under attack: sinks, cycles, chaos, diverged cells, an effort pass, an ensemble."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from quavsweep.config import Sweep, parse_sweep

# RK4 diverges from about rho = 400 on. Starts of an ensemble cannot go on with an effort, so there are two sweeps.
_MEASURES = "measures: {lyapunov: {exponents: 3, block: 5}}"
GRID = f"""
name: grid
model: lorenz
initial: {{x: 1.0, y: 1.0, z: 20.0}}
axes:
  rho: {{start: 0.5, stop: 620, num: 64}}
integrate: {{method: rk4, dt: 0.02, transient: 10, duration: 50}}
{_MEASURES}
effort: {{max_duration: 120}}
"""
ENSEMBLE = f"""
name: ensemble
model: lorenz
initial: {{z: 20.0}}
axes:
  rho: {{values: [0.5, 14, 20, 22.5, 28, 60, 100.5, 160, 350, 900]}}
  ensemble: {{num: 8, seed: 1, box: {{x: [-10, 10], y: [-10, 10]}}}}
integrate: {{method: rk4, dt: 0.02, transient: 10, duration: 50}}
{_MEASURES}
"""
# Where the sweep does not matter, this one takes half a second.
QUICK = GRID.partition("effort")[0]
for old, new in (("name: grid", "name: quick"), ("num: 64", "num: 16"), (": 10, duration: 50", ": 2, duration: 6")):
    assert old in QUICK, old
    QUICK = QUICK.replace(old, new)
TILE_CELLS = 5


@dataclass(frozen=True)
class Subject:
    """A sweep under attack."""

    name: str
    text: str
    tile_cells: int = TILE_CELLS

    @cached_property
    def sweep(self) -> Sweep:
        """The sweep."""
        return parse_sweep(self.text, f"{self.name}.yaml")

    @property
    def tiles(self) -> int:
        """Number of tiles."""
        return -(-self.sweep.grid.size // self.tile_cells)


SUBJECTS = (Subject("grid", GRID), Subject("ensemble", ENSEMBLE))
SMALL = Subject("quick", QUICK)
