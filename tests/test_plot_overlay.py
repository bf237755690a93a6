"""Curves over maps and marks along an axis: equations, files, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.lines import Line2D

from quavsweep.errors import ConfigError
from quavsweep.plot import make_figure
from quavsweep.plot.contour import roots, zero_lines
from quavsweep.plot.equation import parse_equation
from quavsweep.result import Result
from tests.conftest import LORENZ, YAW
from tests.plot_runs import CELL, LINE, MAP, legend_texts, run

LOG = LORENZ.replace(
    "rho: {start: 0.5, stop: 600, num: 60}",
    "sigma: {start: 1, stop: 100, num: 3, spacing: log}\n  rho: {start: 1, stop: 100, num: 3, spacing: log}",
)


def _curve(result: Result, *texts: str) -> list[np.ndarray]:
    """Return the points of the black lines over the first panel."""
    axes = make_figure(result, overlays=texts).axes[0]
    return [line.get_xydata() for line in axes.lines if line.get_color() == "black"]


def test_an_equation_is_drawn_where_it_holds() -> None:
    points = np.concatenate(_curve(run(MAP), "2.9e-5*(2*Omega1**2 + 2*(Omega1+c)**2) = 0.468*9.81"))
    x, y = points.T
    np.testing.assert_allclose(2.9e-5 * (2 * x**2 + 2 * (x + y) ** 2), 0.468 * 9.81, rtol=1e-5)
    assert y.min() == pytest.approx(2.5)
    assert y.max() == pytest.approx(7.5)


def test_an_equation_knows_the_fixed_parameters() -> None:
    result = run(MAP)
    (points,) = _curve(result, "Ix*c = 5*Ix")
    np.testing.assert_allclose(points[:, 1], 5)


def test_an_equation_is_drawn_on_logarithmic_axes() -> None:
    (points,) = _curve(run(LOG), "sigma*rho = 100")
    np.testing.assert_allclose(points.prod(axis=1), 100, rtol=1e-6)
    assert len(points) > 300


def test_a_pole_is_no_curve() -> None:
    pieces = _curve(run(MAP), "c = 5 + 100/(Omega1 - 200)")
    x, y = np.concatenate(pieces).T
    np.testing.assert_allclose((y - 5) * (x - 200), 100, atol=2)
    with pytest.raises(ConfigError, match="does not cross the map"):
        make_figure(run(MAP), overlays=["1/(c - 5)**3 = 0"])


def test_a_function_has_no_curve_where_it_is_no_number() -> None:
    (points,) = _curve(run(MAP), "sqrt(c - 5) = Omega1/400")
    assert points[:, 1].min() > 5


def test_curves_can_be_told_apart_on_any_colour() -> None:
    axes = make_figure(run(MAP), overlays=["c = 4", "c = 5", "c = 6"]).axes[0]
    casing, lines = axes.lines[::2], axes.lines[1::2]
    assert {line.get_color() for line in casing} == {"white"}
    assert {line.get_color() for line in lines} == {"black"}
    assert all(a.get_linewidth() > b.get_linewidth() + 1 for a, b in zip(casing, lines, strict=True))
    assert all(a.get_zorder() < b.get_zorder() for a, b in zip(casing, lines, strict=True))
    assert len({str(line.get_linestyle()) + str(line._dash_pattern) for line in lines}) == 3


def test_curves_have_their_labels_in_one_legend(tmp_path: Path) -> None:
    path = tmp_path / "measured.csv"
    path.write_text("c,Omega1\n3,100\n7,200\n")
    texts = ["hovering: c = 5", "c*Omega1=1000", str(path), f"from a file: {path}", "_a$b: c = 4"]
    figure = make_figure(run(MAP), overlays=texts)
    assert legend_texts(figure) == ["hovering", "c*Omega1=1000", "measured", "from a file", r" _a\$b"]


def test_a_file_has_its_columns_in_any_order(tmp_path: Path) -> None:
    path = tmp_path / "curve.csv"
    path.write_text("\ufeffnote, c ,Omega1\nx,3,100\n\ny,9,200\n", encoding="utf-8")
    figure = make_figure(run(MAP), overlays=[str(path)])
    axes = figure.axes[0]
    np.testing.assert_array_equal(axes.lines[1].get_xydata(), [[100, 3], [200, 9]])
    assert axes.get_ylim() == (2.5, 7.5)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("", r"curve.csv:1: has no column Omega1; the header is to name the axes, Omega1 and c"),
        ("Omega1,d\n1,2\n", r"curve.csv:1: has no column c"),
        ("Omega1,c\n100,3\n200,four\n", r"curve.csv:3: c is 'four'; it should be a finite number"),
        ("Omega1,c\n100,3\n200\n", r"curve.csv:3: c is missing"),
        ("Omega1,c\n100,inf\n200,4\n", r"curve.csv:2: c is 'inf'"),
        ("Omega1,c\n100,3\n", r"a curve needs at least two points, here are 1"),
        ("Omega1,c\n100,30\n200,40\n", r"does not cross the map; Omega1 is 50 to 500, c is 3 to 7"),
        ('Omega1,c\n"100,3\n', r"is no CSV file"),
        ("\x89PNG\0", r"is no CSV file"),
    ],
)
def test_what_is_wrong_with_a_file_is_named(tmp_path: Path, content: str, says: str) -> None:
    path = tmp_path / "curve.csv"
    path.write_bytes(content.encode("latin-1"))
    with pytest.raises(ConfigError, match=says):
        make_figure(run(MAP), overlays=[str(path)])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("c", "is neither a file nor an equation; write left = right, or the path of a CSV file"),
        ("none.csv", "is neither a file nor an equation"),
        ("c = ", "is not an equation"),
        ("c == 5", "is not an equation; write left = right, for example c = 5"),
        ("c = 5 = 6", "is not an equation"),
        ("Omga1 = 5", r"nothing is called Omga1, did you mean Omega1\?; there are Omega1, c, Ix, Iy"),
        ("c = p", "nothing is called p"),
        ("c = sqrt", "nothing is called sqrt"),
        ("c = (((", "cannot be read; it may hold numbers, names"),
        ("c = lambda", "cannot be read"),
        ("c = 2 ^ 2", r"2 \^ 2 is not accepted; it may hold numbers"),
        ("c = abs(Omega1)", r"abs\(Omega1\) is not accepted"),
        ("c = __import__('os').getpid()", "is not accepted"),
        ("c = Omega1.real", "Omega1.real is not accepted"),
        ("c = [5][0]", "is not accepted"),
        ("c = (lambda: 5)()", "is not accepted"),
        ("c = 'a'", "'a' is not accepted"),
        ("c = 1j", "1j is not accepted"),
        ("c = True", "True is not accepted"),
        ("c = sqrt(1, 2)", r"sqrt\(1, 2\) is not accepted"),
        ("c = 5 if c else 6", "is not accepted"),
        ("c = 1" + "0" * 400, "cannot be read"),
        ("c = " + "(" * 500 + "1" + ")" * 500, "longer than 1000 characters"),
        ("c = " + "(" * 400 + "1" + ")" * 400, "cannot be read"),
        ("c = 9", "does not cross the map; Omega1 is 50 to 500, c is 3 to 7"),
        ("c = 9**9**9**9", "does not cross the map"),
        ("sqrt(-c) = 1", "does not cross the map"),
    ],
)
def test_what_is_no_curve_is_refused(text: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        make_figure(run(MAP), overlays=[text])


def test_one_axis_has_marks_where_an_equation_holds() -> None:
    axes = make_figure(run(LINE), overlays=["(rho - 100)*(rho - 200) = 0", "sigma: rho = 3*sigma"]).axes[0]
    marks = [line.get_xdata()[0] for line in axes.lines if isinstance(line, Line2D) and len(set(line.get_xdata())) == 1]
    np.testing.assert_allclose(sorted(marks), [30, 100, 200], rtol=1e-9)
    assert {"sigma", "(rho - 100)*(rho - 200) = 0"} < set(legend_texts(axes))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("rho = -5", "does not cross the axis; rho is 0.5 to 600"),
        ("1/(rho-9) = 0", "does not cross"),
        ("rho = rho", "does not cross"),
    ],
)
def test_a_mark_beyond_the_axis_is_refused(text: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        make_figure(run(LINE), overlays=[text])


def test_curves_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "curve.csv"
    path.write_text("rho,x\n1,2\n3,4\n")
    with pytest.raises(ConfigError, match="a curve from a file needs a map; this sweep has one axis"):
        make_figure(run(LINE), overlays=[str(path)])
    with pytest.raises(ConfigError, match="a curve needs a map; this sweep has no axes"):
        make_figure(run(CELL), overlays=["rho = 5"])


def test_roots_and_lines_of_known_functions() -> None:
    np.testing.assert_allclose(roots(np.linspace(0.1, 10, 101), np.sin), np.pi * np.arange(1, 4), rtol=1e-12)
    assert not len(roots(np.linspace(0.1, 10, 101), lambda x: 1 / (x - 3.1)))
    x = np.linspace(-2, 2, 101)

    def circle(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return x**2 + y**2 - 1

    (line,) = zero_lines(x, x, circle(x[:, None], x[None, :]), circle)
    np.testing.assert_allclose(np.hypot(*line.T), 1, atol=1e-3)
    np.testing.assert_array_equal(line[0], line[-1])


def test_an_equation_has_the_value_of_python() -> None:
    text = "-x**2 + 3*y/(x - +2) = sqrt(x*y) - 1e-1*2**-x**.5"
    x, y = 1.7, 0.3
    equation = parse_equation(text, ["x", "y"])
    expected = -(x**2) + 3 * y / (x - +2) - (np.sqrt(x * y) - 1e-1 * 2 ** -(x**0.5))
    assert float(equation.difference({"x": x, "y": y})) == pytest.approx(expected, rel=1e-14)
    assert equation.names == {"x", "y"}


def test_maps_without_a_curve_have_no_legend_for_them() -> None:
    assert not make_figure(run(YAW)).legends
