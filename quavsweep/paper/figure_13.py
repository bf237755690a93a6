"""Figure 13: the ellipsoid of zero power (24), Theorem 1 (25), and the true bound of the energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.equilibrium_search import find_equilibria
from quavsweep.analysis.quadrotor.bound import (
    energy_ellipsoid,
    largest_energy,
    stationary_points,
    theorem_1_energy,
    theorem_1_holds,
    zero_power_ellipsoid,
)
from quavsweep.analysis.quadrotor.casimir import energy_extremes
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.observed import observed
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.bound import Scene, make_bound_figure
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHAOS = 2  # the cell of the sweep
AFTER = 100.0  # s, from when the orbit is on its chaotic set
LESS_DRAG = {"k4": 6e-5}  # N m s/rad, a craft for which Theorem 1 does not hold
LESS_TEXT = ", ".join(f"{name} = {value:g} N m s/rad" for name, value in LESS_DRAG.items())
BETWEEN = 5e-3  # of the level, that a point between two states 0.1 s apart may be off by
ROUNDING = 1e-9  # of the bound: where E1 is a sink, energy tends to the bound from above


def analyse(runs: Runs) -> Findings:
    """Check (24) and (25), and find the bound for the crafts of a sweep."""
    result = runs["figure_08"]
    craft = {**result.sweep.parameters, "Omega1": float(result["Omega1"][CHAOS])}
    late = result["time"] >= AFTER
    energy, power = observed(result, ("casimir_energy", "casimir_power"))[CHAOS, late].T
    scene, bound = make_scene(result, craft, power), bounds(runs["bound"])
    less = {**craft, **LESS_DRAG}
    yes = {True: "yes", False: "no"}
    points = np.concatenate([scene.saddle, scene.sinks])
    on_it = np.abs(scene.zero_power.value(points)).max() < 1e-6 * scene.zero_power.level
    turning = np.concatenate([scene.extremes.maxima, scene.extremes.minima])
    far = BETWEEN * scene.zero_power.level
    seen = f"{power.size:,} states of the chaotic orbit"
    printed, level = {row.key: row for row in read_printed("figure_13")}, _printed_level(craft)
    true, claimed = float(largest_energy(less).energy), float(theorem_1_energy(less))
    computed = {
        "ellipsoid.right": Computed(
            yes[bool(np.isclose(level, scene.zero_power.level))],
            note=f"printed {level:.4g} W, by completing the square {scene.zero_power.level:.4g} W at Table 2",
        ),
        "ellipsoid.equilibria": Computed(yes[bool(on_it)]),
        "ellipsoid.inside": Computed(_sign(power[scene.zero_power.value(scene.orbit) < 0]), note=seen),
        "ellipsoid.outside": Computed(_sign(power[scene.zero_power.value(scene.orbit) > 0]), note=seen),
        "ellipsoid.extremes": Computed(yes[bool(np.abs(scene.zero_power.value(turning)).max() < far)]),
        "theorem_1.stationary": Computed(
            float(stationary_points(craft)), note=f"{stationary_points(less)} with {LESS_TEXT}"
        ),
        "theorem_1.points": Computed(
            printed["theorem_1.points"].paper if _has_printed_points(craft) else "others",
            note="the origin is a minimum; r of the other is twice that of E1",
        ),
        "theorem_1.table_2": Computed(yes[bool(theorem_1_holds(craft))]),
        "theorem_1.any": Computed(
            yes[bool(bound.holds.all())],
            note=f"with {LESS_TEXT} the maximum is {true:.5f} J, not {claimed:.5f} J",
        ),
    }
    return Findings(computed, data=scene, tables=(_table(craft, less, float(energy.max())),), text=bound.text)


def _sign(power: np.ndarray) -> str:
    """Return the sign that all of some powers have, in a word."""
    return "positive" if (power > 0).all() else "negative" if (power < 0).all() else "both"


def _has_printed_points(craft: dict[str, float]) -> bool:
    """Whether the energy is largest at the printed point, and there is none but this and the origin."""
    r = 2 * craft["d"] * (craft["c"] ** 2 + 2 * craft["c"] * craft["Omega1"]) / craft["k6"]
    return int(stationary_points(craft)) == 2 and np.allclose(largest_energy(craft).at, [0.0, 0.0, r])


def _printed_level(craft: dict[str, float]) -> float:
    """Return the right side of (24) as it is printed."""
    return (craft["d"] ** 2 * craft["c"] ** 2 + 2 * craft["c"] * craft["Omega1"] ** 2) / craft["k6"]


def make_scene(result: Result, craft: dict[str, float], power: np.ndarray) -> Scene:
    """Return what the figure shows, from the Casimir power along the chaotic orbit."""
    orbit = result["orbit"][CHAOS, result["time"] >= AFTER]
    zero = zero_power_ellipsoid(craft)
    rest = find_equilibria(result.sweep.model, craft).states
    return Scene(
        model=result.sweep.model,
        orbit=orbit,
        extremes=energy_extremes(orbit, power),
        saddle=2.0 * zero.centre[None],
        sinks=rest[rest[:, 0] != 0],
        zero_power=zero,
        supremum=energy_ellipsoid(craft, float(theorem_1_energy(craft))),
    )


@dataclass(frozen=True)
class Bounds:
    """What becomes of orbits of many crafts, held against the bound of each.

    Parameters
    ----------
    holds : (crafts) bool
        Whether Theorem 1 does.
    outside, inside : int
        Orbits that start outside; orbits that end inside, of all of them.
    left : int
        Orbits that were outside after they had been inside.
    count : int
    highest : float
        Largest energy at an end, as a share of the bound.
    """

    holds: np.ndarray
    outside: int
    inside: int
    left: int
    count: int
    highest: float

    @property
    def text(self) -> str:
        """The same in words."""
        return (
            f"Of {self.count} orbits of {self.holds.size} crafts and flights, {self.outside} start outside the "
            f"ellipsoid C <= max C; {self.inside} end inside, {self.left} left it again. At the end the energy is "
            f"{self.highest:.9f} times the bound at most. Theorem 1 holds for {int(self.holds.sum())} of the "
            f"{self.holds.size}."
        )


def bounds(result: Result) -> Bounds:
    """Hold the orbits of a sweep over parameters and starts against the bound."""
    axes = result.sweep.points.axes
    grids = np.meshgrid(*(axis.values for axis in axes), indexing="ij")
    crafts: dict[str, float | np.ndarray] = {
        **result.sweep.parameters,
        **{axis.name: grid for axis, grid in zip(axes, grids, strict=True)},
    }
    share = observed(result, ("casimir_energy",))[..., 0] / largest_energy(crafts).energy[..., None, None]
    inside = share <= 1.0 + ROUNDING
    entered = np.maximum.accumulate(inside, axis=-1)
    return Bounds(
        holds=theorem_1_holds(crafts),
        outside=int((~inside[..., 0]).sum()),
        inside=int(inside[..., -1].sum()),
        left=int((entered & ~inside).any(axis=-1).sum()),
        count=inside[..., 0].size,
        highest=float(share[..., -1].max()),
    )


def _table(craft: dict[str, float], less: dict[str, float], seen: float) -> Table:
    """Return the bounds of two crafts, and the energy that is seen on the chaotic orbit of the first."""
    rows = [
        (
            name,
            f"{float(2 * theorem_1_energy(of)):.5f}",
            f"{float(theorem_1_energy(of)):.5f}",
            f"{float(largest_energy(of).energy):.5f}",
            highest,
        )
        for name, of, highest in (("Table 2", craft, f"{seen:.5f}"), (LESS_TEXT, less, ""))
    ]
    head = ("craft", "right side of (25) (J)", "max C by Theorem 1 (J)", "max C (J)", "seen on the chaotic orbit (J)")
    speeds = f"Omega1 = {craft['Omega1']:g} rad/s, c = {craft['c']:g} rad/s"
    return Table(f"The largest Casimir energy at zero power, {speeds}", head, rows)


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw the three panels."""
    return make_bound_figure(findings.data)


FIGURE = Item(
    name="figure_13",
    title="The chaotic orbit, the ellipsoid of zero power that it crosses, and the supremum of its energy",
    configs=("figure_08", "bound"),
    analyse=analyse,
    draw=draw,
)
