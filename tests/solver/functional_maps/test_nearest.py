"""Nearest neighbours against all distances."""

import numpy as np
import pytest

from solver.arrays import IntArray, RealArray
from solver.functional_maps import mutual_nearest_points, nearest_points


def brute_force(queries: RealArray, points: RealArray) -> IntArray:
    """Row of the nearest of `points` to each query, one query after the other."""
    found = [np.argmin(((points - query) ** 2).sum(axis=1)) for query in queries]
    return np.array(found, dtype=np.int64)


# One block, one with several points, and several blocks of queries.
SIZES = [(1, 1), (7, 300), (300, 7), (500, 900), (150, 4000)]


@pytest.mark.parametrize(("points", "others"), SIZES)
def test_mutual_nearest_points_are_those_of_all_distances(points: int, others: int) -> None:
    random = np.random.default_rng(points)
    ours, theirs = random.standard_normal((points, 8)), random.standard_normal((others, 8))
    images, back = mutual_nearest_points(ours, theirs)
    np.testing.assert_array_equal(images, brute_force(ours, theirs))
    np.testing.assert_array_equal(back, brute_force(theirs, ours))


def test_mutual_nearest_points_take_single_precision() -> None:
    random = np.random.default_rng(1)
    ours = random.standard_normal((400, 12)).astype(np.float32)
    theirs = random.permutation(ours)[:200]
    images, back = mutual_nearest_points(ours, theirs)
    np.testing.assert_array_equal(ours[back], theirs)
    np.testing.assert_array_equal(images[back], np.arange(200))


def test_nearest_points_are_the_same_however_many_are_asked_at_once() -> None:
    random = np.random.default_rng(4)
    queries, points = random.standard_normal((50, 8)), random.standard_normal((90000, 8))
    np.testing.assert_array_equal(nearest_points(queries, points), brute_force(queries, points))


def test_the_first_of_equally_near_points_is_found() -> None:
    ours, theirs = np.zeros((3, 2)), np.ones((4, 2))
    images, back = mutual_nearest_points(ours, theirs)
    assert images.tolist() == [0, 0, 0]
    assert back.tolist() == [0, 0, 0, 0]
