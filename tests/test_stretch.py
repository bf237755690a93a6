"""Stretches of a line: against every possible answer, and where they are plain."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from quavsweep.analysis.stretch import best_border, best_interval, stretches
from quavsweep.codes import Region
from quavsweep.paper.interval import Interval, Line, border, shares
from quavsweep.paper.row import ERRORS


def test_single_points_do_not_end_a_stretch() -> None:
    has = np.array([0, 1, 1, 0, 1, 0, 0, 1, 0, 0, 0, 1, 1], dtype=bool)
    assert stretches(has) == [(1, 4), (7, 7), (11, 12)]
    assert stretches(has, gap=0) == [(1, 2), (4, 4), (7, 7), (11, 12)]
    assert stretches(has, gap=3) == [(1, 12)]
    assert stretches(np.zeros(4, dtype=bool)) == []


@pytest.mark.parametrize("seed", range(20))
def test_no_interval_and_no_border_makes_fewer_mistakes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    has = rng.random(12) < rng.random()
    found = best_interval(has)
    mistakes = {
        (a, b): int(np.sum(~has[a : b + 1]) + np.sum(has) - np.sum(has[a : b + 1]))
        for a, b in itertools.combinations_with_replacement(range(12), 2)
    }
    if found is None:
        assert not has.any()
    else:
        assert mistakes[found] == min(mistakes.values())
    before, after = has, rng.random(12) < 0.5
    wrong = [int(np.sum(~before[:k]) + np.sum(~after[k:])) for k in range(13)]
    assert wrong[best_border(before, after)] == min(wrong)


def test_a_border_lies_between_its_columns_and_a_stray_one_does_not_move_it() -> None:
    region = np.array([Region.SINK] * 6 + [Region.CHAOS] * 6, dtype=np.int8)
    region[[2, 9]] = Region.PERIODIC
    line = Line(np.arange(12.0), {"1 s": region, "2 s": np.full(12, Region.SINK, dtype=np.int8)})
    sinks, chaos = Interval(0, 4, Region.SINK), Interval(4, 11, Region.CHAOS)
    found = border(line, sinks, chaos)
    assert found.value == 5.5
    assert ERRORS * found.error == 1.0
    assert "2 of 12" in found.note
    table = shares(line, [sinks, chaos], "title")
    assert table.rows[0][2] == "80% of 5"
    assert table.rows[1][3] == "0% of 8; most are sink"
    strips = line.strips([sinks, chaos])
    assert strips["paper"].tolist() == [Region.SINK] * 4 + [Region.CHAOS] * 8
