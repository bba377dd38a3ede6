"""Nearest points of a triangulated surface."""

import numpy as np

from synthetic.nearest_surface import NearestSurface
from tests.solver.shapes import icosphere


def test_the_nearest_points_of_a_sphere_are_in_the_same_direction() -> None:
    sphere = icosphere(4)
    outside = 1.5 * icosphere(2).vertices
    found = NearestSurface(sphere).nearest(outside)
    np.testing.assert_allclose(found.points, outside / 1.5, atol=0.02)
    np.testing.assert_allclose(found.normals, outside / 1.5, atol=0.02)
