"""Figure 12: Cases 1, 2 and 3 in flight, from 200 m to the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.turn import turns
from quavsweep.paper.item import Findings, Item, Table
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.flight import course, make_flight_figure
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SWEEP = "cases"
NAMES = ("p", "phi", "theta", "psi", "az", "z")
STILL = 0.1  # of Case 1's roll rate; a case that stays below is almost still
NEAR = 0.95  # of the largest magnitude, from which on an earlier turn is told as well
ACCURACY = 1e-4  # rad, s, m/s2: what the flights have in common with SciPy's DOP853 at 1e-10, by the tests


def analyse(runs: Runs) -> Findings:
    """Find impacts and the extremes before them, and compare the cases."""
    flown = runs[SWEEP]
    ends = flown["first_time"]
    last = np.where(np.isfinite(ends), ends, flown["time"][-1])
    printed = {row.key: row for row in read_printed("figure_12")}
    peak = {name: [largest(flown, name, i, last[i]) for i in range(len(last))] for name in ("p", "phi", "theta", "az")}
    size = {name: np.abs([value for _, value in of]) for name, of in peak.items()}
    computed: dict[str, Computed] = {}
    for i in (0, 1):
        (when, fall), case = peak["az"][i], f"case{i + 1}"
        side = float(printed[f"{case}.roll"].number or 0)
        at, roll = largest(flown, "phi", i, last[i], side)
        note = f"largest {'below' if side < 0 else 'above'} 0 before the impact, at {at:.2f} s"
        if peak["phi"][i][0] != at:
            note += "; the largest of all is {1:+.4f} at {0:.2f} s".format(*peak["phi"][i])
        computed |= {
            f"{case}.roll": Computed(roll, ACCURACY, note),
            f"{case}.degrees": Computed(float(np.degrees(roll)), float(np.degrees(ACCURACY)), "the same"),
            f"{case}.time": Computed(at, ACCURACY, "of the same"),
            f"{case}.az": Computed(fall, ACCURACY, f"largest, at {when:.2f} s{_earlier(flown, 'az', i, when)}"),
            f"{case}.az.time": Computed(when, ACCURACY, f"of the same{_earlier(flown, 'az', i, when)}"),
            f"{case}.impact": Computed(float(ends[i]), ACCURACY, "z = 0, by root finding"),
        }
    computed |= {
        "roll.pitch.1": _told(size["phi"][0] > size["theta"][0], "larger", "smaller"),
        "roll.pitch.2": _told(size["phi"][1] > size["theta"][1], "larger", "smaller"),
        "amplitude": _told(size["p"][1] < size["p"][0], "smaller", "larger"),
        "slower": _told(ends[0] > ends[1], "Case 1", "Case 2"),
        "still": _told(size["p"][2] < STILL * size["p"][0], "almost zero", "not zero"),
        "weight": Computed(size["az"][0] / flown.sweep.parameters["g"], note="in units of g"),
        "still.az": _told(size["az"][2] < STILL * size["az"][0], "very small", "not small"),
        "still.angles": _told(
            all(size[name][2] < STILL * size[name][0] for name in ("phi", "theta")), "relatively stable", "not stable"
        ),
        "yaw": _told(_range(flown, "psi") > max(_range(flown, "phi"), _range(flown, "theta")), "yaw", "another"),
        "improved": _told(size["phi"][1] < size["phi"][0], "improved", "not improved"),
    }
    return Findings(computed, tables=(_table(flown, ends, peak),), text=_text(flown, ends))


def largest(flown: Result, name: str, case: int, end: float, side: float = 0.0) -> tuple[float, float]:
    """Return time and value of the largest magnitude of a quantity at its turns before some time.

    With `side` it is the largest of those with that sign.
    """
    time, value = turns(flown["time"], course(flown, name)[case])
    before = (time < end) & (side * value >= 0.0)
    if not before.any():
        return np.nan, np.nan
    k = int(np.argmax(np.abs(value[before])))
    return float(time[before][k]), float(value[before][k])


def _earlier(flown: Result, name: str, case: int, at: float) -> str:
    """Return an earlier turn that comes near to the largest magnitude, at some time, in words; empty if none does."""
    time, value = turns(flown["time"], course(flown, name)[case])
    near = (time < at) & (np.abs(value) >= NEAR * abs(value[np.argmin(np.abs(time - at))]))
    return f"; {value[near][0]:.4f} at {time[near][0]:.2f} s before" if near.any() else ""


def _range(flown: Result, name: str) -> float:
    """Return by how much an angle of Case 3 varies."""
    return float(np.ptp(course(flown, name)[2]))


def _told(holds: bool | np.bool_, yes: str, no: str) -> Computed:
    return Computed(yes if holds else no)


def _table(flown: Result, ends: np.ndarray, peak: dict[str, list[tuple[float, float]]]) -> Table:
    """Return what each case does until its impact."""
    model = flown.sweep.model
    head = ("case", "impact [s]", *(f"largest {name} [{model.quantity(name).unit}] at [s]" for name in peak))
    rows = [
        (
            str(i + 1),
            f"{end:.4f}" if np.isfinite(end) else "none",
            *(f"{of[i][1]:.4f} at {of[i][0]:.3f}" for of in peak.values()),
        )
        for i, end in enumerate(ends)
    ]
    return Table("Extremes before the impact", head, rows)


def _text(flown: Result, ends: np.ndarray) -> str:
    """Say how far the third case falls, and what the angles are at."""
    method, dt = flown.sweep.config.integrate.method, flown.sweep.clock.dt
    time, height = float(flown["time"][-1]), float(course(flown, "z")[2][-1])
    aloft = f"Case 3 is still {height:.1f} m high after {time:g} s"
    third = f"Case 3 reaches the ground at {ends[2]:.2f} s" if np.isfinite(ends[2]) else aloft
    return f"{third}. Integrated by {method} with dt = {dt:g} s; turns are found between stored states."


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw the three flights over time."""
    flown = runs[SWEEP]
    return make_flight_figure(flown, NAMES, ("Case 1", "Case 2", "Case 3"), flown["first_time"])


FIGURE = Item(
    "figure_12",
    "Roll rate, Euler angles, vertical acceleration and height of Cases 1, 2 and 3, each until its impact",
    analyse,
    draw,
    (SWEEP,),
)
