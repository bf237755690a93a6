"""Figure 4: a sink and transient chaos, with their largest exponents and dimensions, in the limit and after a time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.dimension import chaotic_dimension, chaotic_dimension_error, lyapunov_dimension
from quavsweep.paper.figure_08 import end_of, orbits, power_of
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.observed import observed
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Computed, Printed
from quavsweep.paper.run import Runs
from quavsweep.plot.power import make_power_figure
from quavsweep.point import Point, compute_point
from quavsweep.result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SINK, CHAOS = 0, 2  # cells of the sweep
CLASSIC = {
    "Lorenz": 0.9056,
    "Chen": 2.024,
}  # largest exponents at (10, 28, 8/3), Sprott, and (35, 3, 28), measured here
LORENZ_DIMENSION = 2.06215  # Sprott
LEAST = 2000.0  # s of chaos: shorter phases tell more of how they ended


def analyse(runs: Runs) -> Findings:
    """Compare exponents and dimensions with their limits, and find when a running average has the printed value."""
    result = runs["figure_08"]
    printed = {row.key: row for row in read_printed("figure_04")}
    sink, dimension = result["lyapunov"][SINK], lyapunov_dimension(result["lyapunov"][SINK])
    single = [compute_point(runs.sweep("figure_04_time"), {"Omega1": result["Omega1"][i]}) for i in (SINK, CHAOS)]
    largest, error, count = chaotic_exponent(runs["figure_04"])
    divergence = float(sink.sum())  # the same everywhere
    many = f"mean of {count} starts while they are chaotic, for {LEAST:g} s or more"
    end = end_of(result, SINK)
    size = float(chaotic_dimension(largest, divergence))
    computed = {
        "region.30": Computed("sink" if str(end.value).startswith("E") else end.value),
        "L1.30": Computed(float(sink[0]), note=f"in the limit; {_when(single[0], printed['L1.30'])}"),
        "dimension.30": Computed(float(dimension)),
        "region.196.4": end_of(result, CHAOS),
        "L1.196.4": Computed(largest, error, f"{many}; {_when(single[1], printed['L1.196.4'])}"),
        "dimension.196.4": Computed(
            size,
            float(chaotic_dimension_error(largest, error, divergence)),
            f"2 + L1 / (L1 + {-divergence:.2g} / s), with an exponent 0 and the sum {divergence:.2g} / s",
        ),
    }
    computed["weak"] = Computed(
        "weaker" if largest < min(CLASSIC.values()) else "not weaker",
        note="by largest exponents, "
        + ", ".join(f"{value:g} of {name}" for name, value in CLASSIC.items())
        + f" per unit of time of their own, which has no unit; by Lyapunov dimension {size:.3f} is more than Lorenz' "
        f"{LORENZ_DIMENSION:g}",
    )
    return Findings(computed, data=observed(result, ("casimir_power",))[..., 0])


def chaotic_exponent(result: Result) -> tuple[float, float, int]:
    """Return the largest exponent while chaotic [1/s], its error from the scatter of starts, and their number."""
    value, phase = result["lyapunov_chaotic"], result["chaotic_until"]
    long = np.isfinite(value) & (phase >= LEAST)
    value, weight = value[long], phase[long] / phase[long].sum()
    mean = float((weight * value).sum())
    return mean, float(np.sqrt((weight**2 * (value - mean) ** 2).sum())), int(long.sum())


def _when(point: Point, printed: Printed) -> str:
    """Return in words when the running average from t = 0 has the value that is printed."""
    time, average = point.averaged_until, point.exponents[:, 0]
    number = printed.number
    assert number is not None
    above = average > float(number)
    crossed = np.flatnonzero(above[1:] != above[:-1])
    if not crossed.size:
        return f"no running average from t = 0 has the printed value within {time[-1]:g} s"
    i = crossed[-1]
    share = (float(number) - average[i]) / (average[i + 1] - average[i])
    last = time[i] + share * (time[i + 1] - time[i])
    times = "at" if crossed.size == 1 else f"{crossed.size} times until {time[-1]:g} s, the last at"
    return f"the running average from t = 0 has the printed value {times} {last:.0f} s"


def draw(runs: Runs, findings: Findings) -> Figure:
    """Draw the two orbits."""
    result = runs["figure_08"]
    chosen = range(SINK, CHAOS + 1, CHAOS - SINK)
    return make_power_figure(orbits(result, findings.data, chosen), power_of(result))


FIGURE = Item(
    name="figure_04",
    title="A sink and the chaotic phase of an orbit, in space and by their Casimir power",
    configs=("figure_08", "figure_04", "figure_04_time"),
    analyse=analyse,
    draw=draw,
)
