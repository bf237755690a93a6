"""The search for the nearest change: on steps, intervals and combs, without a single integration."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from quavsweep.margin.search import FINE, HALVINGS, Found, nearest_change, run_searches

SCAN = [np.linspace(0.0, 50.0, 101)[1:]]
Tumbles = Callable[[np.ndarray], np.ndarray]


def _found(tumbles: Tumbles, scan: list[np.ndarray] = SCAN) -> tuple[Found, list[float]]:
    asked: list[float] = []

    def ask(questions: list[tuple[int, np.ndarray]]) -> list[np.ndarray]:
        asked.extend(x for _, distances in questions for x in distances.tolist())
        return [tumbles(distances) for _, distances in questions]

    (found,) = run_searches([nearest_change(scan)], ask)
    return found, asked


def _holds(found: Found, tumbles: Tumbles) -> None:
    """The bracket is 0.99 d and 1.01 d, and what was asked there is what is said."""
    assert None not in (found.distance, found.inner, found.outer)
    assert found.inner == pytest.approx(0.99 * found.distance, rel=1e-14)
    assert found.outer == pytest.approx(1.01 * found.distance, rel=1e-14)
    base, inner, outer = tumbles(np.array([0.0, found.inner, found.outer]))
    assert (base, inner, outer) == (found.base, found.base, not found.base)


@pytest.mark.parametrize("edge", [0.001, 0.037, 0.5, 3.3333, 12.0, 49.99])
@pytest.mark.parametrize("base", [False, True])
def test_a_step_is_found_to_a_thousandth(edge: float, base: bool) -> None:
    def tumbles(x: np.ndarray) -> np.ndarray:
        return (x > edge) != base

    found, asked = _found(tumbles)
    _holds(found, tumbles)
    assert found.base == base
    assert found.distance == pytest.approx(edge, rel=FINE)
    assert len(asked) == len(set(asked)) < 180


def test_a_thin_interval_that_the_scan_hits_is_bracketed() -> None:
    def tumbles(x: np.ndarray) -> np.ndarray:
        return (x > 19.9999) & (x < 20.001)

    found, _ = _found(tumbles)
    _holds(found, tumbles)
    assert found.outer == 20.0


def test_an_interval_between_two_points_of_the_scan_is_not_seen() -> None:
    found, _ = _found(lambda x: (x > 20.1) & (x < 20.4))
    assert found == Found(False)


def test_a_comb_yields_the_nearest_tooth_that_was_seen() -> None:
    """Teeth that thin out towards the base point, as at a fractal boundary."""

    def tumbles(x: np.ndarray) -> np.ndarray:
        return (x > 1.0) & (np.modf(37.0 / np.maximum(x, 1e-9))[0] < 0.3)

    found, asked = _found(tumbles)
    _holds(found, tumbles)
    seen = np.array(asked)
    nearer = seen[seen < found.inner]
    assert not tumbles(nearer).any()


@pytest.mark.parametrize("seed", range(20))
def test_random_fractal_boundaries_are_bracketed(seed: int) -> None:
    """An answer that is a coin's beyond some distance: every question may show a nearer change."""

    def tumbles(x: np.ndarray) -> np.ndarray:
        bits = np.floor(np.abs(np.sin(1e5 * (x + seed))) * 1e6)
        return (x > 5.0) & (bits % 7 < 1)

    found, _ = _found(tumbles)
    _holds(found, tumbles)


@pytest.mark.parametrize("edge", [49.9, 49.99, 49.9999])
def test_nothing_is_asked_beyond_the_model(edge: float) -> None:
    """The change lies so near to the end that 1.01 d is beyond it: another d is told, to a percent."""
    asked: list[float] = []

    def ask(questions: list[tuple[int, np.ndarray]]) -> list[np.ndarray]:
        asked.extend(x for _, distances in questions for x in distances.tolist())
        return [distances > edge for _, distances in questions]

    (found,) = run_searches([nearest_change(SCAN, farthest=50.0)], ask)
    _holds(found, lambda x: x > edge)
    assert max(asked) == 50.0
    assert found.distance == pytest.approx(edge, rel=0.012)


def test_of_a_change_at_the_base_point_itself_a_bound_is_known() -> None:
    found, _ = _found(lambda x: x > 0)
    assert found.inner == 0
    assert found.distance == found.outer
    assert 0 < (found.outer or 0) <= 0.5 * 0.5**HALVINGS


def test_a_change_as_near_as_numbers_go_is_bracketed_above_the_finest_distance() -> None:
    def ask(questions: list[tuple[int, np.ndarray]]) -> list[np.ndarray]:
        return [distances > 1e-9 for _, distances in questions]

    (found,) = run_searches([nearest_change(SCAN, 1e-12)], ask)
    _holds(found, lambda x: x > 1e-9)
    assert found.distance == pytest.approx(1e-9, rel=FINE)
    (bound,) = run_searches([nearest_change(SCAN, 1e-8)], ask)
    assert (bound.inner, bound.outer) == (0.0, bound.distance)
    assert 1e-9 < (bound.distance or 0) <= 1e-8


def test_no_change_within_reach() -> None:
    assert _found(lambda x: x < 0)[0] == Found(False)
    assert _found(lambda x: x >= 0)[0] == Found(True)
    assert _found(lambda x: x >= 0, [np.empty(0)])[0] == Found(True)


def test_later_stages_are_asked_only_without_a_change() -> None:
    stages = [np.linspace(1, 10, 10), np.linspace(11, 50, 40)]
    found, asked = _found(lambda x: x > 4.2, stages)
    assert found.distance == pytest.approx(4.2, rel=FINE)
    assert max(asked) == 10
    assert max(_found(lambda x: x > 44.2, stages)[1]) == 50


def test_searches_share_rounds() -> None:
    rounds = []

    def ask(questions: list[tuple[int, np.ndarray]]) -> list[np.ndarray]:
        rounds.append([number for number, _ in questions])
        return [distances > 3 * (number + 1) for number, distances in questions]

    found = run_searches([nearest_change(SCAN) for _ in range(5)], ask)
    assert [round(f.distance or 0.0, 1) for f in found] == [3.0, 6.0, 9.0, 12.0, 15.0]
    assert rounds[0] == [0, 1, 2, 3, 4]
    assert len(rounds) <= 5
