"""Samples of a target in several metrics in turn."""

import numpy as np
import pytest

from solver.prototype.matching import sample_in_turn
from solver.shape import Shape
from solver.shape.choices import CommuteTime, Geodesic
from tests.solver import shapes

METRICS = CommuteTime(), Geodesic()


@pytest.mark.parametrize("count", [1, 2, 7, 40])
def test_each_metric_in_turn_gives_its_next_farthest_point(count: int) -> None:
    mesh = shapes.torus(20, 12)
    whole = Shape(mesh)
    expected: list[int] = []
    for samples in zip(*(whole.sampling(metric, count).indices for metric in METRICS), strict=True):
        for sample in samples:
            if sample not in expected:  # both metrics may have the same farthest point
                expected.append(sample)
    found = sample_in_turn(Shape(mesh), METRICS, count)
    np.testing.assert_array_equal(found, expected[:count])


def test_all_vertices_can_be_sampled() -> None:
    shape = Shape(shapes.icosphere(1))
    found = sample_in_turn(shape, METRICS, shape.n_vertices)
    np.testing.assert_array_equal(np.sort(found), np.arange(shape.n_vertices))
