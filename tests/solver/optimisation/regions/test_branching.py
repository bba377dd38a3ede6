"""The compiled spread of labels against plain NumPy."""

import numpy as np
import pytest

from solver.optimisation.regions.branching import _weighted_distances
from tests.solver.problems import distances_of


def test_weighted_distances() -> None:
    random = np.random.default_rng(0)
    distances = distances_of(random.normal(size=(9, 3)))
    for count in (0, 1, 6):
        places, weights = random.permutation(9)[:count], random.random(count)
        expected = weights @ distances[np.ix_(places, places)] @ weights
        assert _weighted_distances(distances, places, weights) == pytest.approx(expected)
