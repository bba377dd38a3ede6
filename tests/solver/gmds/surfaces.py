"""Surfaces on which the true place of a point is known, between the vertices too."""

from functools import cache

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.gmds import SurfacePoints
from solver.mesh import TriangleMesh, triangle_mesh
from tests.solver import shapes


class StraightMetric:
    """Distances through space between the vertices of a mesh, as an unknown kind of metric."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self.vertices = mesh.vertices

    @property
    def n_vertices(self) -> int:
        return len(self.vertices)

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) distances from (S,) vertices."""
        apart: FloatArray = np.linalg.norm(self.vertices[sources][:, None] - self.vertices, axis=2)
        return apart

    def between(self, points: IntArray) -> FloatArray:
        """(A, A) distances among (A,) vertices."""
        return self.distances(points)[:, points]


def plane_points(seed: int, count: int) -> FloatArray:
    """(N, 3) points of the rectangle that ``shapes.plane_grid`` triangulates, off its border."""
    random = np.random.default_rng(seed)
    places = random.uniform([0.1, 0.1], [1.4, 0.9], size=(count, 2))
    return np.column_stack([places, np.zeros(count)])


def nearest_vertices(mesh: TriangleMesh, places: FloatArray) -> IntArray:
    """(N,) vertices nearest to some places."""
    away = np.linalg.norm(mesh.vertices[:, None] - places, axis=2)
    nearest: IntArray = np.argmin(away, axis=0)
    return nearest


def random_points(mesh: TriangleMesh, seed: int, count: int) -> SurfacePoints:
    """Points anywhere on a surface, a few of them on edges and on vertices."""
    random = np.random.default_rng(seed)
    u = random.dirichlet(np.ones(3), size=count)
    u[::5, 0] = 0.0
    u[::10, 1] = 0.0
    return SurfacePoints(random.integers(mesh.n_faces, size=count), u / u.sum(axis=1)[:, None])


@cache
def blob_twice() -> tuple[TriangleMesh, TriangleMesh]:
    """``shapes.blob(3)`` and another triangulation of nearly the same surface."""
    sphere = shapes.icosphere(3)
    turn, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))
    first, second = (
        triangle_mesh(shapes.with_bumps(directions), sphere.faces)
        for directions in (sphere.vertices, sphere.vertices @ turn)
    )
    return first, second
