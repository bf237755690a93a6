"""Attractor tables: ends that are the same are put together, others, mirror images too, kept apart."""

from __future__ import annotations

import numpy as np

from quavsweep.analysis.attractor import OTHER, find_attractors


def test_mirror_images_are_two_and_rounding_makes_no_third() -> None:
    rng = np.random.default_rng(1)
    side = rng.integers(0, 2, 500)
    points = np.array([[0.6, 1.4, 0.4], [-0.6, -1.4, 0.4]])[side] + 1e-9 * rng.standard_normal((500, 3))
    kind = np.ones(500, int)
    kind[::50] = 0
    table = find_attractors(kind, points)
    np.testing.assert_allclose(table.point, [[-0.6, -1.4, 0.4], [0.6, 1.4, 0.4]], atol=1e-8)
    np.testing.assert_array_equal(table.number, np.where(kind == 0, 0, 2 - side))
    np.testing.assert_array_equal(table.count, [((side == 1) & (kind == 1)).sum(), ((side == 0) & (kind == 1)).sum()])
    np.testing.assert_array_equal(points[table.first], table.point)


def test_coordinates_that_are_zero_but_for_rounding_do_not_order() -> None:
    for sign in (1, -1):
        points = np.array([[sign * 1e-17, 2.0], [-sign * 1e-17, 1.0]])
        np.testing.assert_array_equal(find_attractors(np.array([1, 1]), points).point[:, 1], [1.0, 2.0])


def test_a_sink_and_a_cycle_at_one_point_are_two() -> None:
    table = find_attractors(np.array([2, 1, 2]), np.zeros((3, 2)))
    np.testing.assert_array_equal(table.kind, [1, 2])
    np.testing.assert_array_equal(table.number, [2, 1, 2])


def test_those_with_most_starts_are_kept() -> None:
    points = np.repeat(np.arange(10.0), np.arange(1, 11))[:, None]
    table = find_attractors(np.ones(55, int), points, most=3)
    np.testing.assert_array_equal(table.point[:, 0], [7, 8, 9])
    np.testing.assert_array_equal(table.count, [8, 9, 10])
    assert (table.number == OTHER).sum() == 28


def test_nothing_certified_is_an_empty_table() -> None:
    table = find_attractors(np.array([0, 1]), np.array([[1.0], [np.nan]]))
    assert not len(table.kind)
    np.testing.assert_array_equal(table.number, [0, 0])


def test_a_cycle_between_sinks_does_not_renumber_them() -> None:
    points = np.array([[1.0, 0.0], [0.0, 0.5], [-1.0, 0.0]])
    alone = find_attractors(np.array([1, 0, 1]), points)
    beside = find_attractors(np.array([1, 2, 1]), points)
    np.testing.assert_array_equal(alone.number, [2, 0, 1])
    np.testing.assert_array_equal(beside.number, [2, 3, 1])
    np.testing.assert_array_equal(beside.kind, [1, 1, 2])
