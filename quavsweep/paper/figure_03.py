"""Figure 3: the pitchfork of the yaw system's equilibria, and its curve in the plane of Omega1 and c."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from quavsweep.analysis.bifurcation import Kind, find_bifurcations
from quavsweep.analysis.bifurcation_curve import bifurcation_curve
from quavsweep.analysis.equilibrium import vector_field
from quavsweep.analysis.equilibrium_search import find_equilibria
from quavsweep.analysis.quadrotor.closed_form import closed_form_equilibria, pitchfork_speed
from quavsweep.analysis.quadrotor.stability import Margins, no_bifurcation
from quavsweep.kernels.lookup import make_program
from quavsweep.models import load_model
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.row import Computed
from quavsweep.paper.run import Runs
from quavsweep.plot.pitchfork import BranchLine, PitchforkData, Region, make_pitchfork_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODEL = load_model("quadrotor_yaw")
SHOWN = 0.0, 200.0  # rad/s, of Omega1
SEARCHED = 280.0  # rad/s
PLANE = ("Omega1", 0.0, 60.0), ("c", 0.5, 7.0)  # rad/s
PLANES = {"5": "figure_05", "9": "figure_09"}  # figures whose planes are looked at, and their sweeps
SAMPLES = 9  # values of Omega1 in each interval at which all equilibria are searched
BISECTED = 1e-7  # of Omega1
TEXT_NAMES = {"E1": "E_1", "E4": "E_2", "E5": "E_3"}  # from those of equations (17) to those of the text


def _analyse(runs: Runs) -> Findings:
    found = find_bifurcations(MODEL, "Omega1", SHOWN[0], SEARCHED)
    pitchfork = next(b for b in found if b.kind is Kind.PITCHFORK)
    closed = pitchfork_speed(MODEL.defaults)
    curve = np.concatenate(bifurcation_curve(MODEL, Kind.PITCHFORK, *PLANE))
    apart = np.abs(pitchfork_speed({**MODEL.defaults, "c": curve[:, 1]}) - curve[:, 0]).max()
    margins = {name: _margins(runs, config) for name, config in PLANES.items()}
    computed = {
        "pitchfork.Omega1": Computed(pitchfork.value),
        "transitions": Computed(f"{len(found)} {found[0].kind}"),
        "below": Computed(_stability(SHOWN[0], pitchfork.value)),
        "above": Computed(_stability(pitchfork.value, SHOWN[1])),
        "to_280": Computed(_stability(pitchfork.value, SEARCHED)),
        "foci.Omega1": Computed(_foci_from(pitchfork.value)),
    }
    data = PitchforkData(
        MODEL,
        "p",
        "Omega1",
        "c",
        [_branch(name, text) for name, text in TEXT_NAMES.items()],
        curve,
        (*PLANE[0][1:], *PLANE[1][1:]),
        (pitchfork.value, MODEL.defaults["c"]),
        (
            Region("$E_1$\nstable", (6.5, 1.5)),
            Region("$E_1$ saddle\n$E_2$, $E_3$ stable", (36.0, 3.5)),
        ),
    )
    return Findings(computed, data, text=_text(pitchfork.value, closed, apart, margins))


def _margins(runs: Runs, config: str) -> Margins:
    """Return how far bifurcations are from the plane of a sweep over Omega1 and another parameter."""
    speed, other = runs.sweep(config).grid.axes
    return no_bifurcation(MODEL.defaults, min(speed.values), other.name, min(other.values), max(other.values))


def _text(value: float, closed: float, apart: float, margins: Mapping[str, Margins]) -> str:
    """Return what was found beside the rows."""
    proved = " and ".join(name for name, margin in margins.items() if margin.holds)
    return (
        f"The closed form of the pitchfork gives {closed:.9f} rad/s, {abs(closed - value):.1e} from what is found by "
        f"following branches; along the curve the two differ by {apart:.1e} rad/s at most. By closed forms over "
        f"intervals E1 is a saddle and the side equilibria are stable in the whole planes of Figures {proved}: no "
        "pitchfork and no Hopf bifurcation crosses them. The side equilibria of the text, E2 and E3, are those that "
        "equations (17) call E4 and E5."
    )


def _stability(low: float, high: float) -> str:
    """Return how many equilibria of which kind there are within an interval of Omega1, if the same throughout."""
    inside = low + (high - low) * np.linspace(0.0, 1.0, SAMPLES + 2)[1:-1] ** 3
    seen = [find_equilibria(MODEL, {"Omega1": value}) for value in inside]
    kinds = {_counted(tuple(kind.split()[0] for kind in equilibria.types)) for equilibria in seen}
    return " or ".join(sorted(kinds)) + ("" if all(equilibria.complete for equilibria in seen) else "?")


def _counted(kinds: tuple[str, ...]) -> str:
    """Return words with how often each comes."""
    return ", ".join(f"{kinds.count(kind)} {kind}" for kind in sorted(set(kinds)))


def _foci_from(pitchfork: float) -> float:
    """Return Omega1 from which the stable pair has complex eigenvalues, by bisection."""
    low, high = pitchfork, SHOWN[1]
    while high - low > BISECTED * high:
        middle = 0.5 * (low + high)
        nodes = "stable node" in find_equilibria(MODEL, {"Omega1": middle}).types
        low, high = (middle, high) if nodes else (low, middle)
    return high


def _branch(name: str, text: str) -> BranchLine:
    """Return the branch of an equilibrium by its name in equations (17), close points near its beginning."""
    start = SHOWN[0] if name == "E1" else float(pitchfork_speed(MODEL.defaults))
    speeds = start + (SHOWN[1] - start) * np.linspace(1e-4, 1.0, 801) ** 2
    states = closed_form_equilibria({**MODEL.defaults, "Omega1": speeds})[name]
    program = make_program(MODEL)
    columns = [speeds if k == "Omega1" else np.full(len(speeds), v) for k, v in MODEL.defaults.items()]
    spectra = np.linalg.eigvals(vector_field(program, states, program.coefficient_values(columns))[1])
    return BranchLine(text, speeds, states[:, 0], spectra.real.max(axis=1) < 0)


def _draw(runs: Runs, findings: Findings) -> Figure:
    return make_pitchfork_figure(findings.data)


FIGURE = Item(
    name="figure_03",
    title="Pitchfork of the equilibria: (a) roll rate against the speed of the front rotors, (b) its curve",
    analyse=_analyse,
    draw=_draw,
)
