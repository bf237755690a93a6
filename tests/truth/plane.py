"""The two planes of the paper, as thumbnails and with other times."""

from __future__ import annotations

from pathlib import Path

from quavsweep import Result, Sweep, load_sweep
from tests.truth.laboratory import Laboratory

CONFIGS = Path(__file__).parents[2] / "configs"
PLANES = ("omega_c", "omega_ix")
THUMBNAIL, SMALL = (91, 41), (13, 7)
LONGER = 10


def plane(name: str, shape: tuple[int, int] | None, *changes: str) -> Sweep:
    """Return a plane on a grid of this shape (None: its own), with some keys changed."""
    path = CONFIGS / f"{name}.yaml"
    if shape is None:
        return load_sweep(path, changes)
    axes = [axis.name for axis in load_sweep(path).grid.axes]
    return load_sweep(path, [*(f"axes.{n}.num={num}" for n, num in zip(axes, shape, strict=True)), *changes])


def thumbnail(laboratory: Laboratory, name: str) -> tuple[Sweep, Result]:
    """Return a thumbnail of a plane, run as its config says."""
    sweep = plane(name, laboratory.choose(THUMBNAIL, SMALL))
    return sweep, laboratory.run(name, sweep)


def long_thumbnail(laboratory: Laboratory, name: str) -> tuple[Sweep, Result]:
    """Return the thumbnail over ten times the time, without early ends."""
    times = {"transient": 1000 * LONGER, "duration": 3000 * LONGER}
    changes = (f"integrate.{key}={value}" for key, value in times.items())
    sweep = plane(name, laboratory.choose(THUMBNAIL, SMALL), *changes, "stop_early=false")
    return sweep, laboratory.run(f"{name}-long", sweep)
