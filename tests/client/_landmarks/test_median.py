"""Geometric median."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from isomatch._landmarks.median import geometric_median

from tests.client._landmarks.surfaces import Floats

SEEDS = st.integers(0, 2**31 - 1)


@settings(max_examples=50)
@given(seed=SEEDS, count=st.integers(1, 7))
def test_no_other_point_has_a_smaller_sum_of_distances(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    points, weights = random.standard_normal((count, 3)), random.random(count) + 0.01
    found = geometric_median(points, weights)

    def total(places: Floats) -> Floats:
        sums: Floats = np.linalg.norm(places[:, None] - points, axis=2) @ weights
        return sums

    scales = 10.0 ** random.uniform(-4, 0.5, size=(500, 1))
    others = np.vstack([points, found + scales * random.standard_normal((500, 3))])
    assert total(found[None])[0] <= total(others).min() * (1.0 + 1e-9)


@settings(max_examples=20)
@given(seed=SEEDS)
def test_of_points_on_a_line_it_is_the_weighted_median(seed: int) -> None:
    random = np.random.default_rng(seed)
    places, weights = np.sort(random.random(5)), random.random(5) + 0.1
    direction = random.standard_normal(3)
    found = geometric_median(places[:, None] * direction, weights)
    half = np.searchsorted(np.cumsum(weights), 0.5 * weights.sum())
    np.testing.assert_allclose(found, places[half] * direction, atol=1e-6)


def test_of_two_points_the_middle_or_the_heavier_one() -> None:
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    np.testing.assert_allclose(geometric_median(points, np.array([0.3, 0.3])), [1.0, 0.0, 0.0])
    np.testing.assert_allclose(geometric_median(points, np.array([0.3, 0.4])), [2.0, 0.0, 0.0])
    np.testing.assert_allclose(geometric_median(points, np.zeros(2)), [1.0, 0.0, 0.0])
    np.testing.assert_allclose(geometric_median(points[[1, 1]], np.ones(2)), [2.0, 0.0, 0.0])
