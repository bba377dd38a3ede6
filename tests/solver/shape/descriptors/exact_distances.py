"""Surfaces on which geodesic distances have a closed form, as metrics."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh
from solver.shape import EmbeddedMetric


class GreatCircles:
    """Geodesic metric of the unit sphere.

    Parameters
    ----------
    mesh
        With vertices on the sphere.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._directions = mesh.vertices

    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
        return len(self._directions)

    def distances(self, sources: IntArray) -> FloatArray:
        """Angles from some vertices to all."""
        cosines = self._directions[sources] @ self._directions.T
        angles: FloatArray = np.arccos(np.clip(cosines, -1.0, 1.0))
        angles[np.arange(len(sources)), sources] = 0.0
        return angles

    def between(self, points: IntArray) -> FloatArray:
        """Angles among some vertices."""
        return self.distances(points)[:, points]


def straight_lines(mesh: TriangleMesh) -> EmbeddedMetric:
    """Geodesic metric of a convex part of the plane."""
    return EmbeddedMetric(mesh.vertices)
