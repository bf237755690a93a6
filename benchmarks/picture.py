"""The pictures: bars against the peers, and work against accuracy."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from benchmarks.machine import describe
from benchmarks.protocol import Protocol
from benchmarks.row import Outcome

# Okabe and Ito's palette, which colour-blind readers tell apart; marks differ as well.
BAR, TARGET = "#0072b2", "#d55e00"
STYLES = {
    "rk4": ("quavsweep, rk4", "#56b4e9", "o"),
    "dp8": ("quavsweep, dp8", "#0072b2", "s"),
    "heyoka": ("heyoka, batch mode", "#d55e00", "^"),
    "JiTCODE": ("JiTCODE, dop853", "#000000", "D"),
}


def draw(outcomes: Sequence[Outcome], path: Path, protocol: Protocol) -> None:
    """Draw what has been measured; a picture without data says so.

    Parameters
    ----------
    path : Path
        Its ending decides the format: .png, .pdf or .svg.
    """
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    draw_bars(left, outcomes)
    details = [outcome.measurement.detail for outcome in outcomes if outcome.measurement is not None]
    draw_curves(right, next((detail["curves"] for detail in details if "curves" in detail), {}))
    machine = describe()
    kind = "quick measurement, " if protocol.quick else ""
    text = f"{kind}{machine['processor']}, one thread, three exponents, numba {machine['packages']['numba']}"
    figure.supxlabel(text, fontsize=8, color="0.3")
    figure.savefig(path, dpi=200)


def draw_bars(axes: Axes, outcomes: Sequence[Outcome]) -> None:
    """Draw how many times more time than the kernel each peer takes; a tick marks the target."""
    shown = [(o.row, o.measurement) for o in reversed(outcomes) if o.row.peer and o.measurement is not None]
    axes.set_title("Time of a peer / time of quavsweep")
    if not shown:
        _say(axes, "no peer was measured")
        return
    values = [measurement.value for _, measurement in shown]
    spread = [
        [v - min(m.values) for v, (_, m) in zip(values, shown, strict=True)],
        [max(m.values) - v for v, (_, m) in zip(values, shown, strict=True)],
    ]
    axes.barh(range(len(shown)), values, height=0.6, color=BAR, xerr=spread, ecolor="0.2", capsize=2)
    for i, (row, measurement) in enumerate(shown):
        bound = row.target.bound if row.target else measurement.value
        label = "target" if i == 0 else None
        axes.plot([bound, bound], [i - 0.42, i + 0.42], color=TARGET, linewidth=2.5, label=label)
        right = max(*measurement.values, bound)
        axes.annotate(f"{measurement.value:.3g}", (right, i), (6, 0), textcoords="offset points", va="center")
    axes.set_yticks(range(len(shown)), [row.peer for row, _ in shown])
    axes.set_xscale("log")
    axes.set_xlim(1.0, 4.0 * max(*values, *(row.target.bound for row, _ in shown if row.target)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("ratio of times, per simulated second and cell")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), frameon=False)
    axes.spines[["top", "right"]].set_visible(False)


def draw_curves(axes: Axes, curves: dict[str, list[dict[str, Any]]]) -> None:
    """Draw the time of a simulated second against the error of the state after 100 s."""
    axes.set_title("Work against accuracy")
    if not curves:
        _say(axes, "not measured")
        return
    for tool, points in curves.items():
        label, colour, marker = STYLES.get(tool, (tool, "#cc79a7", "v"))
        front = useful(points)
        errors, times = [p["error"] for p in front], [p["ns"] / 1e3 for p in front]
        axes.plot(errors, times, marker=marker, markersize=4.5, color=colour, label=label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.invert_xaxis()
    axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("error of the state after 100 s (rad/s)")
    axes.set_ylabel("time per simulated second and cell (µs)")
    axes.grid(True, color="0.9")
    axes.set_axisbelow(True)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)


def useful(points: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the points that are clearly more exact than all before; where rounding rules, more work is wasted."""
    front: list[dict[str, Any]] = []
    for point in points:
        if not front or point["error"] < 0.7 * front[-1]["error"]:
            front.append(point)
    return front


def _say(axes: Axes, text: str) -> None:
    axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes, color="0.4")
    axes.set_axis_off()
