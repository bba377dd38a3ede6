"""Projection onto a triangulated surface: nearest points."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel
from solver.mesh import TriangleMesh, vertex_normals
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
        self._faces = mesh.faces
        self._corners = mesh.vertices[mesh.faces]
        self._normals = vertex_normals(mesh.vertices, mesh.faces)
        self._centres = KDTree(self._corners.mean(axis=1))

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
        which, share = _nearest_of(self._corners, near.astype(np.int64), points)
        face, rows = self._faces[which], np.arange(len(points))
        normals = np.einsum("pc,pcd->pd", share, self._normals[face])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
        places = np.einsum("pc,pcd->pd", share, self._corners[which])
        return Nearest(places, face[rows, share.argmax(axis=1)], normals)


@kernel
def _nearest_of(
    corners: FloatArray, near: IntArray, points: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Triangle nearest to each point, of those in a row of `near`, and barycentric coordinates.

    By the regions of a triangle's plane (Ericson, Real-Time Collision Detection, 5.1.5).
    """
    which, share = near[:, 0].copy(), np.zeros((len(points), 3))
    for k in range(len(points)):
        least = np.inf
        for face in near[k]:
            a, b, c, p = corners[face, 0], corners[face, 1], corners[face, 2], points[k]
            d1 = d2 = d3 = d4 = d5 = d6 = 0.0
            for d in range(3):
                d1, d2 = d1 + (b[d] - a[d]) * (p[d] - a[d]), d2 + (c[d] - a[d]) * (p[d] - a[d])
                d3, d4 = d3 + (b[d] - a[d]) * (p[d] - b[d]), d4 + (c[d] - a[d]) * (p[d] - b[d])
                d5, d6 = d5 + (b[d] - a[d]) * (p[d] - c[d]), d6 + (c[d] - a[d]) * (p[d] - c[d])
            s = t = 0.0
            at_c, at_b, at_a = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
            if d1 <= 0.0 and d2 <= 0.0:
                pass
            elif d3 >= 0.0 and d4 <= d3:
                s = 1.0
            elif d6 >= 0.0 and d5 <= d6:
                t = 1.0
            elif at_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
                s = d1 / (d1 - d3)
            elif at_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
                t = d2 / (d2 - d6)
            elif at_a <= 0.0 and d4 >= d3 and d5 >= d6:
                t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
                s = 1.0 - t
            else:
                s, t = at_b / (at_a + at_b + at_c), at_c / (at_a + at_b + at_c)
            square = 0.0
            for d in range(3):
                square += (a[d] + s * (b[d] - a[d]) + t * (c[d] - a[d]) - p[d]) ** 2
            if square < least:
                least, which[k] = square, face
                share[k, 0], share[k, 1], share[k, 2] = 1.0 - s - t, s, t
    return which, share
