"""The suite `accuracy`: what a simulated second with three exponents costs at equal error of the state after 100 s."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.protocol import MissingError, Protocol, compare, ratios
from benchmarks.row import Measurement, Row, at_least
from benchmarks.setting import Setting, all_settings, cheapest, our_cheapest
from quavsweep.kernels.method import METHODS

STRIDE = {"heyoka": 2, "JiTCODE": 1}  # of the settings that the picture shows; every sixth of ours
UNIT = "ns per simulated second and cell"


def heyoka_over_kernel(error: float, protocol: Protocol) -> Measurement:
    """Time of heyoka over ours, each with its cheapest setting for an error."""
    return _at_equal_error(cheapest(("heyoka",), error), our_cheapest(error), protocol)


def jitcode_over_kernel(protocol: Protocol) -> Measurement:
    """Time of JiTCODE at a tolerance of 1e-9 over ours with the cheapest setting that is as exact."""
    theirs = next(s for s in all_settings("JiTCODE") if s.label.endswith("1e-09"))
    return _at_equal_error(theirs, our_cheapest(theirs.error), protocol)


def _at_equal_error(theirs: Setting, ours: Setting, protocol: Protocol) -> Measurement:
    samples = compare([theirs.contender, ours.contender], protocol)
    microseconds = [f"{np.median(samples[s.tool]) / 1e3:.3g}" for s in (theirs, ours)]
    note = (
        f"{theirs.tool} {theirs.label}: {microseconds[0]} us, error {theirs.error:.1e}; "
        f"{ours.tool} {ours.label}: {microseconds[1]} us, error {ours.error:.1e}"
    )
    return Measurement(ratios(samples, theirs.tool, ours.tool), samples, UNIT, note)


def work(protocol: Protocol) -> Measurement:
    """Work against accuracy of every method and peer; the figure is RK4 over our best at an error of 1e-9."""
    shown: list[Setting] = []
    missing: list[str] = []
    for tool in (*METHODS, "heyoka", "JiTCODE"):
        try:
            shown += all_settings(tool)[:: STRIDE.get(tool, 6)]
        except MissingError as error:
            missing.append(str(error))
    names = [f"{setting.tool}, {setting.label}" for setting in shown]
    sides = [replace(setting.contender, name=name) for setting, name in zip(shown, names, strict=True)]
    times = compare(sides, Protocol(samples=protocol.samples, seconds=0.1))
    curves: dict[str, list[dict[str, Any]]] = {setting.tool: [] for setting in shown}
    for setting, name in zip(shown, names, strict=True):
        point = {"error": setting.error, "setting": setting.label, "ns": float(np.median(times[name]))}
        curves[setting.tool].append({**point, "samples": times[name]})
    plain, best = cheapest(("rk4",), 1e-9), our_cheapest(1e-9)
    samples = compare([plain.contender, best.contender], protocol) if best is not plain else {}
    values = ratios(samples, plain.tool, best.tool) if samples else [1.0]
    note = "; ".join([f"rk4 {plain.label}; {best.tool} {best.label}", *missing])
    return Measurement(values, samples, UNIT, note, {"curves": curves})


def _heyoka_row(power: int, bound: float) -> Row:
    title = f"heyoka, error 1e-{power}"
    measure = partial(heyoka_over_kernel, 10.0**-power)
    return Row(f"heyoka-1e-{power}", "accuracy", title, "x", at_least(bound), measure, peer=title)


ROWS = (
    *(_heyoka_row(power, bound) for power, bound in ((6, 10), (9, 10), (12, 5))),
    Row("work", "accuracy", "rk4 / our best, error 1e-9", "x", None, work),
)
