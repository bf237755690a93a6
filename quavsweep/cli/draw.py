"""The verbs `plot` and `point`: figures of runs and of single cells."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from quavsweep.cli.describe import numbers
from quavsweep.cli.option import PATH, KeyValue, Limits, model_option
from quavsweep.cli.stop import stop_on_signals
from quavsweep.cli.text import say, table, warn
from quavsweep.errors import DamageError

if TYPE_CHECKING:
    from quavsweep.point import Point


@click.command()
@click.argument("sources", metavar="DIR|FILE...", nargs=-1, required=True, type=PATH)
@click.option(
    "--out",
    type=PATH,
    metavar="FILE",
    help="PNG, PDF or SVG; default map.png beside the result, plot.png with options.",
)
@click.option("--variable", "variables", multiple=True, metavar="V", help="Draw this one; may be repeated.")
@click.option("--limits", type=Limits(), metavar="A,B", help="Limits of the colours, or of a line's axis.")
@click.option("--overlay", "overlays", multiple=True, metavar="CURVE", help="A curve over a map: CSV file or equation.")
@click.option("--horizon", type=float, metavar="T", help="What a run to this time would have said, by stored batches.")
@click.option("--at", "at", multiple=True, type=KeyValue(), metavar="KEY=VALUE", help="Fix an axis at a value.")
def plot(
    sources: tuple[Path, ...],
    out: Path | None,
    variables: tuple[str, ...],
    limits: tuple[float, float] | None,
    overlays: tuple[str, ...],
    horizon: float | None,
    at: tuple[tuple[str, float], ...],
) -> None:
    """Draw a run, finished or not; several give a panel each.

    \b
    quavsweep plot results/omega_c
    quavsweep plot results/omega_c --variable settle_time --out settle.pdf
    quavsweep plot results/omega_c --variable final_state.p --limits -2,2
    quavsweep plot results/omega_c --at c=5
    quavsweep plot results/omega_c --horizon 2000
    quavsweep plot results/omega_c --overlay "hovering: \\
        2.9e-5*(2*Omega1**2 + 2*(Omega1+c)**2) = 0.468*9.81"
    quavsweep plot results/omega_c results/omega_ix --out both.png

    A variable is one of the result, with a component where it has some: region, lyapunov.2, final_state.p. A CSV file
    of a curve has a header that names the axes.
    """
    from quavsweep.plot import draw
    from quavsweep.result import open_result
    from quavsweep.store.doubt import doubted

    results = [open_result(source, horizon).at(**dict(at)) for source in sources]
    for name, asked in at:
        used = {**results[0].sweep.parameters, **results[0].sweep.config.initial}.get(name, round(asked))
        if used != asked:
            warn(f"{name} = {used:g}, the value of the grid that is nearest to {asked:g}")
    folder = sources[0] if sources[0].is_dir() else sources[0].parent
    plain = len(sources) == 1 and not (variables or limits or overlays or at or horizon)
    path = out or folder / ("map.png" if plain else "plot.png")  # map.png is the run's own
    with doubted(sources[0], any(result.stored.foreign for result in results)):
        say(draw(results, path, variables=variables, limits=limits, overlays=overlays))


@click.command()
@click.argument("source", metavar="CONFIG|DIR", type=PATH)
@click.argument("values", metavar="KEY=VALUE...", nargs=-1, type=KeyValue())
@click.option("--out", type=PATH, metavar="FILE", help="PNG, PDF or SVG; default point.png in DIR, or here.")
@click.option("--variable", "variables", multiple=True, metavar="V", help="Draw this too: orbit.casimir_power.")
@click.option("--no-plot", is_flag=True, help="Only print the numbers.")
@model_option
def point(
    source: Path,
    values: tuple[tuple[str, float], ...],
    out: Path | None,
    variables: tuple[str, ...],
    no_plot: bool,
    model: Path | None,
) -> None:
    """Compute one cell, to the bit the map's, and draw its orbit.

    \b
    quavsweep point results/omega_c Omega1=240 c=5
    quavsweep point configs/omega_c.yaml Omega1=240.25 c=5 r=0.01

    Every axis needs a value; parameters and initial states may be given too. Values between those of the grid are
    used as they are. The figure shows orbit, time series, exponents converging, and the spectrum of the first state.
    """
    stop_on_signals(None, "begins anew")
    from quavsweep.config import load_sweep
    from quavsweep.point import compute_point
    from quavsweep.store import RunFolder

    folder = RunFolder(source) if source.is_dir() else None
    if folder is not None:
        folder.must_exist()
    single = compute_point(load_sweep(folder.config if folder else source, model=model), dict(values))
    rows = numbers(single, dict(values))
    different: list[str] = []
    if folder is not None and single.indices is not None and folder.result.is_file():
        different = _different(single, folder.result)
        found = f"{', '.join(different)} differ" if different else "equal to the bit"
        rows.append(("result.h5", f"cell {_index(single.indices)}: {found}"))
    elif single.indices is None:
        rows.append(("cell", "none of the grid"))
    if not no_plot:
        from quavsweep.plot import draw_point

        rows.append(("figure", str(draw_point(single, out or (source if folder else Path()) / "point.png", variables))))
    say(table(rows))
    if different:
        raise DamageError("the stored cell is another one", str(source), "another engine or toolchain made it?")


def _index(indices: tuple[int, ...]) -> str:
    return f"[{', '.join(map(str, indices))}]"


def _different(single: Point, path: Path) -> list[str]:
    """Return the variables whose bits differ from those of the result."""
    import numpy as np

    from quavsweep.codes import Status
    from quavsweep.result import open_result

    result = open_result(path)
    stored = {name: np.asarray(result.part(name, single.indices or ())) for name in single.values}
    if int(stored["status"]) in (Status.NOT_COMPUTED, Status.FAILED):
        return ["all of it (the cell is not computed there)"]
    return [name for name, value in single.values.items() if np.asarray(value).tobytes() != stored[name].tobytes()]
