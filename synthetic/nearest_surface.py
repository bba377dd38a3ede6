"""Projection onto a triangulated surface: nearest points."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.mesh import TriangleMesh, nearest_in_triangle, vertex_normals
from synthetic.implicit import Skin

_NEIGHBOURS = 12
"""Candidate triangles for each point: those whose centroids are nearest."""


class Nearest(NamedTuple):
    """Points of a surface.

    Attributes
    ----------
    points
        (p, 3) float64.
    vertices
        (p,) int64, the vertex of its triangle that is nearest to each.
    normals
        (p, 3) float64, vertex normals interpolated.
    """

    points: FloatArray
    vertices: IntArray
    normals: FloatArray


class NearestSurface:
    """Nearest points of a mesh, and the mesh as a level set for :mod:`.remeshing`.

    Parameters
    ----------
    mesh
        With triangles of similar size.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._vertices, self._faces = mesh.vertices, mesh.faces
        self._normals = vertex_normals(mesh.vertices, mesh.faces)
        self._centres = KDTree(mesh.vertices[mesh.faces].mean(axis=1))

    def __call__(self, points: FloatArray) -> Skin:
        """Height of points above the surface, its gradient, and a thickness of 1 everywhere."""
        found = self.nearest(points)
        value = np.einsum("pd,pd->p", points - found.points, found.normals)
        return Skin(value, found.normals, np.ones(len(points)))

    def nearest(self, points: FloatArray) -> Nearest:
        """Nearest points of the surface.

        Parameters
        ----------
        points
            (p, 3) float64, near the surface.
        """
        many = min(_NEIGHBOURS, len(self._faces))
        near = np.reshape(self._centres.query(points, k=many)[1], (len(points), many))
        which, share = _nearest_of(self._vertices, self._faces, near.astype(np.int64), points)
        face, rows = self._faces[which], np.arange(len(points))
        normals = np.einsum("pc,pcd->pd", share, self._normals[face])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
        places = np.einsum("pc,pcd->pd", share, self._vertices[face])
        return Nearest(places, face[rows, share.argmax(axis=1)], normals)


@kernel
def _nearest_of(
    vertices: FloatArray, faces: IntArray, near: IntArray, points: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Triangle nearest to each point, of those in a row of `near`, and barycentric coordinates."""
    which, share = near[:, 0].copy(), np.zeros((len(points), 3))
    for k in range(len(points)):
        least = np.inf
        for face in near[k]:
            a, b, c = faces[face]
            square, s, t = nearest_in_triangle(points[k], vertices, a, b, c)
            if square < least:
                least, which[k] = square, face
                share[k, 0], share[k, 1], share[k, 2] = 1.0 - s - t, s, t
    return which, share
