"""The figure of a single cell, for models of any number of states."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import FillBetweenPolyCollection
from matplotlib.figure import Figure

from quavsweep.codes import Region
from quavsweep.config import Sweep, parse_sweep
from quavsweep.errors import ConfigError
from quavsweep.models import Model, Parameter, State
from quavsweep.plot import draw_point, make_point_figure
from quavsweep.plot.decimate import MOST, MOST_ORBIT, extremes, strided
from quavsweep.plot.spectrum import power_spectrum
from quavsweep.point import Point
from tests.plot_runs import legend_texts

CONFIG = """
name: single
model: lorenz
initial: {INITIAL}
parameters: {k: 2.5}
integrate: {dt: 0.01, transient: 20, duration: 80}
"""


def _sweep(count: int, monkeypatch: pytest.MonkeyPatch) -> Sweep:
    """Return a sweep of a model with so many states, u0, u1 ..."""
    names = [f"u{i}" for i in range(count)]
    scope: dict[str, object] = {}
    exec(f"def rhs({', '.join(names)}, k, m): return ({', '.join(names)},)", scope)
    states = tuple(State(name, "rad/s", f"u_{{{i}}}") for i, name in enumerate(names))
    model = Model("many", scope["rhs"], states, (Parameter("k", 1.0, "kg m2"), Parameter("m", 3.0)), time_unit="s")
    monkeypatch.setattr("quavsweep.config.load.load_model", lambda name: model)
    return parse_sweep(CONFIG.replace("INITIAL", ", ".join(f"{name}: {i}" for i, name in enumerate(names))))


def make_point(count: int, monkeypatch: pytest.MonkeyPatch, *, end: float = 100.0, n: int = 4001, k: int = -1) -> Point:
    """Return a point whose state u_i is i + sin(2 pi (1 + i) t / 10)."""
    time = np.linspace(0, end, n)
    i = np.arange(count)
    orbit = i + np.sin(2 * np.pi * (1 + i) * time[:, None] / 10)
    averaged = np.linspace(25, 100, 10)
    exponents = np.linspace(0.1, -1, count)[: count if k < 0 else k] + 1 / averaged[:, None]
    values = {"region": np.array(Region.CHAOS), "lyapunov": exponents[-1], "equilibrium": np.full(count, np.nan)}
    return Point(_sweep(count, monkeypatch), values, time, orbit, averaged, exponents, np.full(exponents.shape, 0.01))


def _panel(figure: Figure, label: str) -> Axes:
    return next(axes for axes in figure.axes if label in axes.get_ylabel() or label in axes.get_xlabel())


@pytest.mark.parametrize("count", [1, 2, 3, 4, 12])
def test_all_states_are_drawn_against_time(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    point = make_point(count, monkeypatch)
    figure = make_point_figure(point)
    panels = [_panel(figure, f"$u_{{{i}}}$") for i in range(count)]
    spaces = len(figure.axes) - count - 2
    assert spaces == (count > 1)
    series = [axes for axes in figure.axes[spaces:] if len(axes.lines) == 3][:count]
    for i, axes in enumerate(series):
        early, late, mark = axes.lines
        assert mark.get_xdata() == [20, 20]
        np.testing.assert_array_equal(np.concatenate([early.get_ydata()[:-1], late.get_ydata()]), point.orbit[:, i])
    assert series[-1].get_xlabel() == r"$t$ ($\mathrm{s}$)"
    assert len(panels) == count


def test_space_has_three_dimensions_a_plane_two(monkeypatch: pytest.MonkeyPatch) -> None:
    space = make_point_figure(make_point(4, monkeypatch)).axes[0]
    assert space.name == "3d"
    plane = make_point_figure(point := make_point(2, monkeypatch)).axes[0]
    assert plane.name == "rectilinear"
    early, late, start = (line.get_xydata() for line in plane.lines)
    np.testing.assert_array_equal(late, point.orbit[800:])
    np.testing.assert_array_equal(early, point.orbit[:801])
    np.testing.assert_array_equal(start, point.orbit[:1])
    assert legend_texts(plane) == ["transient", "after it", "start"]
    assert plane.lines[0].get_rasterized()


def test_a_cell_that_ended_in_its_transient_has_halves(monkeypatch: pytest.MonkeyPatch) -> None:
    point = make_point(2, monkeypatch, end=10.0)
    figure = make_point_figure(point)
    assert legend_texts(figure.axes[0]) == ["first half", "last half", "start"]
    assert len(figure.axes[1].lines) == 2
    np.testing.assert_array_equal(figure.axes[0].lines[1].get_xydata(), point.orbit[2000:])


def test_exponents_settle_with_bands_of_their_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    point = make_point(3, monkeypatch)
    point.errors[:3] = np.inf
    axes = _panel(make_point_figure(point), "averaged until")
    for k in range(3):
        np.testing.assert_array_equal(
            axes.lines[k].get_xydata(), np.column_stack([point.averaged_until, point.exponents[:, k]])
        )
    assert len([c for c in axes.collections if isinstance(c, FillBetweenPolyCollection)]) == 3
    assert legend_texts(axes)[1] == r"$\lambda_{2} = -0.440 \pm 0.010$"
    low, high = axes.get_ylim()
    assert low < -0.99
    assert high < 0.5


def test_a_sink_has_its_exact_exponents_and_its_equilibrium(monkeypatch: pytest.MonkeyPatch) -> None:
    point = make_point(3, monkeypatch)
    exact, rest = np.array([-0.1, -0.2, -3.0]), np.array([1.0, 2.0, 3.0])
    values = {"region": np.array(Region.SINK), "lyapunov": exact, "equilibrium": rest}
    figure = make_point_figure(dataclasses.replace(point, values=values))
    axes = _panel(figure, "averaged until")
    dashed = [line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--"]
    assert dashed == list(exact)
    assert legend_texts(axes)[-1] == "exact"
    assert legend_texts(axes)[0] == r"$\lambda_{1} = -0.1$"
    np.testing.assert_array_equal(np.ravel(figure.axes[0].lines[3].get_data_3d()), rest)


def test_the_spectrum_has_its_peak_at_the_frequency(monkeypatch: pytest.MonkeyPatch) -> None:
    axes = _panel(make_point_figure(make_point(3, monkeypatch)), "relative power of $u_{0}$")
    frequency, power = axes.lines[0].get_data()
    assert frequency[np.argmax(power)] == pytest.approx(0.1, abs=0.01)
    assert axes.get_xlabel() == "frequency (Hz)"
    assert axes.get_yscale() == "log"
    assert axes.get_xlim()[1] < 1


def test_power_of_known_signals() -> None:
    time = 0.1 * np.arange(1000)
    frequency, power = power_spectrum(5 + np.sin(2 * np.pi * time) + 0.1 * np.sin(6 * np.pi * time), 0.1)
    assert frequency[0] == pytest.approx(0.01)
    assert power[frequency.searchsorted(0.999)] == 1
    assert power[frequency.searchsorted(2.999)] == pytest.approx(0.01)
    assert not len(power_spectrum(np.full(100, 3.0), 0.1)[0])
    assert not len(power_spectrum(np.full(100, np.nan), 0.1)[0])
    assert not len(power_spectrum(np.arange(5.0), 0.1)[0])


def test_the_title_says_what_is_not_default(monkeypatch: pytest.MonkeyPatch) -> None:
    title = make_point_figure(make_point(2, monkeypatch)).get_suptitle()
    assert r"$k = 2.5\,\mathrm{kg}\,\mathrm{m}^{2}$" in title
    assert "m = 3" not in title
    assert r"$u_{1}(0) = 1\,\mathrm{rad}\,\mathrm{s}^{-1}$" in title
    assert title.endswith("chaos")
    assert max(map(len, make_point_figure(make_point(12, monkeypatch)).get_suptitle().split("\n"))) < 500


@pytest.mark.parametrize("case", ["diverged", "one time", "no exponents", "not averaged", "all nan", "constant"])
def test_odd_points_are_no_error(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    point = make_point(3, monkeypatch, k=0 if case == "no exponents" else -1)
    if case == "diverged":
        point.orbit[3000:] = 1e300
        point.orbit[3500:] = np.inf
        point.exponents[5:] = np.nan
    if case == "one time":
        point = dataclasses.replace(point, time=point.time[:1], orbit=point.orbit[:1])
    if case == "not averaged":
        empty = {"averaged_until": np.empty(0), "exponents": np.empty((0, 3)), "errors": np.empty((0, 3))}
        point = dataclasses.replace(point, **empty)
    if case == "all nan":
        point.orbit[:] = np.nan
    if case == "constant":
        point.orbit[:] = 1.0
    make_point_figure(point).draw_without_rendering()


def test_vector_figures_of_long_orbits_are_small_and_the_same_each_time(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    point = make_point(3, monkeypatch, n=30_001)
    noise = np.random.default_rng(1).normal(size=point.orbit.shape)
    point = dataclasses.replace(point, orbit=point.orbit + noise)
    for suffix in (".pdf", ".svg"):
        first, second = (draw_point(point, tmp_path / f"{name}{suffix}").read_bytes() for name in "ab")
        assert first == second
        assert len(first) < 2e6
    space, series = make_point_figure(point).axes[:2]
    assert all(len(line.get_data_3d()[0]) <= MOST_ORBIT for line in space.lines)
    assert all(len(line.get_xdata()) <= MOST + 2 for line in series.lines)
    shown = np.concatenate([line.get_ydata() for line in series.lines[:2]])
    assert (shown.min(), shown.max()) == (point.orbit[:, 0].min(), point.orbit[:, 0].max())


def test_long_lines_keep_their_extremes() -> None:
    values = np.sin(np.arange(100_000.0) ** 2)
    values[[777, 50_000]] = 9, -9
    values[90_000:95_000] = np.nan
    kept = extremes(values, 400)
    assert len(kept) <= 402
    assert (np.diff(kept) > 0).all()
    assert {0, 777, 50_000, 99_999} <= set(kept)
    assert list(extremes(values[:400], 400)) == list(range(400))
    assert len(strided(100_000, 300)) <= 300
    assert strided(100_000, 300)[-1] == 99_999
    assert list(strided(7, 10)) == list(range(7))


def test_a_point_has_the_formats_of_all_figures(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no figure can be written as .jpg; use .png, .pdf or .svg"):
        draw_point(make_point(1, monkeypatch), tmp_path / "x.jpg")
