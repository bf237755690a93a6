"""Sweeps, results and cells in rows of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from quavsweep.cli.text import count

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Mapping, Sequence

    import numpy as np

    from quavsweep.config import Sweep
    from quavsweep.point import Point
    from quavsweep.result import Result
    from quavsweep.summary import Check

MOST_NUMBERS = 6  # of a measure, that are printed for a single cell


def described(name: str, sweep: Sweep) -> str:
    """Return name, model and grid of a sweep in a line."""
    shape = " x ".join(f"{axis.name} {len(axis)}" for axis in sweep.grid.axes)
    cells = count(sweep.grid.size, "cell")
    return f"{name}: {sweep.model.name}, " + (f"{shape} = {cells}" if shape else cells)


def shares(result: Result) -> list[tuple[str, str]]:
    """Return rows that say how the cells are shared out, and how far the numbers can be trusted."""
    from quavsweep.codes import REGION
    from quavsweep.summary import summarise

    summary = summarise(result)
    meanings = {code.name: code.meaning for code in REGION}
    rows = [(meanings[name], _share(n, summary.cells)) for name, n in summary.regions.items()]
    if not result.sweep.grid.axes:
        rows += measured(result.sweep, {name: result[name] for name in result.variables})
    if summary.was_chaotic:
        rows.append(("chaotic on the way", _share(summary.was_chaotic, summary.cells)))
    unit = "" if result.sweep.model.time_unit == "1" else f" 1/{result.sweep.model.time_unit}"
    rows.append(("sum check", _checked(summary.sum_error, "sums miss the mean divergence by", unit)))
    rows.append(("zero check", _checked(summary.zero_error, "exponents along the flow miss 0 by", unit)))
    return rows


def _checked(check: Check, what: str, unit: str) -> str:
    """Return the worst value of a self-check in words."""
    if check.worst is None:
        return f"not available: {check.missing}"
    return f"{what} {check.worst:.1e}{unit} at most"


def measured(sweep: Sweep, values: Mapping[str, np.ndarray]) -> list[tuple[str, str]]:
    """Return rows of what the measures of a single cell found, as far as it is a few numbers."""
    rows = []
    for variable in sweep.measures.outputs:
        value, unit = values[variable.name], sweep.unit(variable)
        if value.size <= MOST_NUMBERS and len(variable.dims) < 2:
            names = [str(n) for dim in variable.dims for n in sweep.dimensions[dim].values] or [""]
            numbers = [float(x) for x in value.reshape(-1)]
            text = ", ".join(f"{name} {x:.6g}".strip() for name, x in zip(names, numbers, strict=True))
            rows.append((variable.name, text + (f" {unit}" if unit not in ("", "1") else "")))
    return rows


def _share(count: int, cells: int) -> str:
    return f"{count:>12,}  {100 * count / cells:5.1f} %"


def numbers(single: Point, given: Container[str]) -> list[tuple[str, str]]:
    """Return what is known of a cell, as rows."""
    from quavsweep.codes import REGION, STATUS, Region

    model, values = single.sweep.model, single.values
    region = int(values["region"])
    chosen = {name: v for name, v in single.sweep.parameters.items() if v != model.defaults[name] or name in given}
    rows = [
        ("parameters", _named(chosen) or "the defaults"),
        ("initial", _named(single.sweep.config.initial)),
        ("region", REGION[region].meaning),
        ("status", STATUS[int(values["status"])].meaning),
    ]
    time = "" if model.time_unit == "1" else f" {model.time_unit}"
    rate = "" if model.time_unit == "1" else f" 1/{model.time_unit}"
    if "lyapunov" in values:
        pairs = zip(values["lyapunov"], values["lyapunov_se"], strict=True)
        rows += [(f"exponent {k}", f"{v:.6g} {_error(e)}{rate}") for k, (v, e) in enumerate(pairs, 1)]
        if region != Region.CHAOS:
            until = f"until {values['chaotic_until']:g}{time}, with {values['lyapunov_chaotic']:.6g}"
            error = _error(float(values["lyapunov_chaotic_se"]))
            rows.append(("was chaotic", f"{until} {error}{rate}" if values["was_chaotic"] else "no"))
    rows.append(("time used", f"{values['time_used']:g}{time}"))
    if values["settle_time"] == values["settle_time"]:
        rows.append(("settled", f"after {values['settle_time']:g}{time}"))
    rows += _end(values, model.state_names, time)
    rows.append(("final state", _named(dict(zip(model.state_names, values["final_state"], strict=True)))))
    return rows + measured(single.sweep, values)


def _end(values: Mapping[str, Any], states: Sequence[str], time: str) -> list[tuple[str, str]]:
    """Return where the orbit ends, as rows: an equilibrium or a cycle, if one is known."""
    if values["period"] == values["period"]:
        return [
            ("period", f"{values['period']:.9g}{time}, hits of the section: {int(values['cycle_hits'])}"),
            ("its point", _named(dict(zip(states, values["cycle_point"], strict=True)))),
            ("multipliers", _complex(values["multiplier_re"], values["multiplier_im"])),
        ]
    if values["equilibrium"][0] == values["equilibrium"][0]:
        return [
            ("equilibrium", _named(dict(zip(states, values["equilibrium"], strict=True)))),
            ("eigenvalues", _complex(values["eigenvalue_re"], values["eigenvalue_im"])),
        ]
    return []


def _complex(real: Iterable[float], imaginary: Iterable[float]) -> str:
    pairs = zip(real, imaginary, strict=True)
    return ", ".join(f"{re:.6g}{im:+.6g}i" if im else f"{re:.6g}" for re, im in pairs)


def _error(error: float) -> str:
    return f"+- {error:.2g}" if error else "(exact)"


def _named(values: Any) -> str:
    return ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
