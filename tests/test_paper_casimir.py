"""The paper's energy items: what they compute from small runs, and what their figures show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import QuadMesh

from quavsweep.codes import REGION, Region
from quavsweep.paper import figure_04, figure_08, figure_13, remark_3
from quavsweep.paper.item import Findings, Item
from quavsweep.paper.observed import observed
from quavsweep.paper.outcome import analysed
from quavsweep.paper.printed import read_printed
from quavsweep.paper.row import Row, Verdict
from quavsweep.paper.run import Runs
from quavsweep.plot.agreement import Told, make_agreement_figure
from quavsweep.plot.style import style
from tests.conftest import YAW
from tests.plot_runs import run

SMALL = {
    "figure_08": ("integrate.duration=14000", "measures.orbit.every=0.1"),
    "figure_04": ("axes.ensemble.num=24", "integrate.duration=3800"),
    "bound": ("axes.ensemble.num=1", "axes.c.values=[5]", "measures.orbit.every=10"),
}
RECORDED = YAW.replace("block: 25}", "block: 25}, orbit: {every: 0.2, after: 600, until: 800}")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(tmp_path_factory.mktemp("paper"), 1, changes=SMALL)


def _verdicts(item: Item, runs: Runs) -> tuple[Findings, dict[str, Verdict]]:
    findings = analysed(item, runs)
    return findings, {row.key: Row(row, findings.computed[row.key]).verdict for row in read_printed(item.name)}


def test_the_four_orbits_end_as_the_paper_says_and_remark_3_sees_it(runs: Runs) -> None:
    findings, verdicts = _verdicts(figure_08.FIGURE, runs)
    assert set(verdicts.values()) == {Verdict.AGREES}
    for row in findings.tables[0].rows:
        speed, least, largest, mean, bound, _, identity, balance = map(float, row)
        assert least < 0 < largest, speed
        assert abs(mean) <= bound
        assert identity < 1e-15 * largest / 1e-2 + 1e-18
        assert abs(balance) < 1e-8
    with style():
        figure = figure_08.draw(runs, findings)
    boxes = [axes for axes in figure.axes if axes.name == "3d"]
    assert len(boxes) == 4
    assert len(figure.axes) == 8


def test_exponents_and_dimension_are_held_against_the_limit(runs: Runs) -> None:
    findings, verdicts = _verdicts(figure_04.FIGURE, runs)
    assert float(findings.computed["L1.30"].value) == pytest.approx(-0.018242, abs=1e-6)
    assert verdicts["L1.30"] is Verdict.DIFFERS
    assert "has the printed value at 872 s" in findings.computed["L1.30"].note
    assert verdicts["dimension.30"] is verdicts["region.196.4"] is Verdict.AGREES
    assert 0.033 < float(findings.computed["L1.196.4"].value) < 0.039
    assert 2.14 < float(findings.computed["dimension.196.4"].value) < 2.18


def test_bounds_of_the_paper(runs: Runs) -> None:
    findings, verdicts = _verdicts(figure_13.FIGURE, runs)
    differing = {key for key, verdict in verdicts.items() if verdict is Verdict.DIFFERS}
    assert differing == {"ellipsoid.right", "theorem_1.any"}
    assert "0.58832 J, not 0.43517 J" in findings.computed["theorem_1.any"].note
    bound = figure_13.bounds(runs["bound"])
    assert bound.inside == bound.count == 50
    assert bound.left == 0
    assert bound.outside > 25
    scene = findings.data
    for points in (scene.extremes.maxima, scene.extremes.minima, scene.saddle, scene.sinks):
        assert np.abs(scene.zero_power.value(points)).max() < figure_13.BETWEEN * scene.zero_power.level
    assert (scene.supremum.value(scene.orbit) < 0).all()
    with style():
        figure = figure_13.draw(runs, findings)
    assert [len(axes.collections) for axes in figure.axes] == [1, 0, 1]


def test_observables_are_those_of_each_cell() -> None:
    result = run(RECORDED)
    part = slice(2, 5)
    power, energy = np.moveaxis(observed(result, ("casimir_power", "casimir_energy"), part), -1, 0)
    assert power.shape == (3, 5, 1001)
    values = {**result.sweep.parameters, "Omega1": result["Omega1"][3], "c": result["c"][4]}
    u = result["orbit"][3, 4]
    inertia = np.array([values[name] for name in ("Ix", "Iy", "Iz")])
    du = np.stack(result.sweep.model.rhs(*u.T, **values), axis=-1)
    np.testing.assert_allclose(power[1, 4], (inertia * u * du).sum(axis=-1), atol=1e-15)
    np.testing.assert_allclose(energy[1, 4], 0.5 * (inertia * u**2).sum(axis=-1))


def test_remark_3_is_compared_cell_by_cell(tmp_path: Path) -> None:
    result = run(RECORDED)
    (case,) = remark_3.cases_of(result, (0.01,))
    both = remark_3.Comparison(case, result["region"])
    assert both.agree.mean() > 0.8
    assert (case[result["region"] == Region.SINK] == 6).all()
    finer = run(YAW.replace("num: 9", "num: 17").replace("num: 5", "num: 9"))
    index = remark_3.same_cells(result, finer)
    assert (finer["Omega1"][index[0]].ravel() == result["Omega1"]).all()
    assert (finer["region"][index] == result["region"]).all()
    with pytest.raises(ValueError, match="Omega1"):
        remark_3.same_cells(finer, result)
    with style():
        figure = make_agreement_figure(result, [Told("regions", REGION, result["region"])] * 2)
    (mesh,) = (c for c in figure.axes[0].collections if isinstance(c, QuadMesh))
    assert (np.asarray(mesh.get_array()).reshape(5, 9) == result["region"].T).all()
