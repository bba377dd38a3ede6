"""Points of a triangulated surface: (t, u), a triangle and barycentric coordinates in it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points y_i = (t_i, u_i) of (7).

    Parameters
    ----------
    faces
        (N,) triangles t.
    barycentric
        (N, 3) weights u of their corners, never negative, with sum 1.
    """

    faces: IntArray
    barycentric: FloatArray

    def __len__(self) -> int:
        return len(self.faces)

    @classmethod
    def at_vertices(cls, mesh: TriangleMesh, vertices: IntArray) -> "SurfacePoints":
        """Return vertices as points of a surface.

        Parameters
        ----------
        mesh
            Of the surface.
        vertices
            (N,) vertex indices. Of the triangles that share one, the first is taken.
        """
        return cls(*mesh.at_vertices(vertices))

    def nearest_vertices(self, mesh: TriangleMesh) -> IntArray:
        """(N,) of the three corners of each point's triangle, the one that lies nearest."""
        corners = mesh.vertices[mesh.faces[self.faces]]
        away = np.linalg.norm(corners - self.positions(mesh.vertices, mesh.faces)[:, None], axis=2)
        nearest: IntArray = mesh.faces[self.faces, np.argmin(away, axis=1)]
        return nearest

    def positions(self, vertices: FloatArray, faces: IntArray) -> FloatArray:
        """(N, 3) where the points lie on the surface of these (V, 3) vertices, (F, 3) faces."""
        found: FloatArray = np.einsum("nc,ncd->nd", self.barycentric, vertices[faces[self.faces]])
        return found

    def first(self, count: int) -> "SurfacePoints":
        """Return the first points."""
        return SurfacePoints(self.faces[:count], self.barycentric[:count])


class Charts(NamedTuple):
    """Planar coordinates of every triangle, and the adjacency of triangles.

    Parameters
    ----------
    faces
        (F, 3) vertex indices.
    corners
        (F, 3) a triangle in its own plane has its corners at (0, 0), (c₀, 0) and (c₁, c₂).
    neighbours
        (F, 3) triangle beyond the edge opposite each corner; -1 where there is none, or where
        more than two triangles meet.
    first, incident
        The triangles round vertex v are ``incident[first[v]:first[v + 1]]``.
    """

    faces: IntArray
    corners: FloatArray
    neighbours: IntArray
    first: IntArray
    incident: IntArray


def charts_of(mesh: TriangleMesh) -> Charts:
    """Planar coordinates of the triangles of a mesh, in O(F log F)."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    base = np.linalg.norm(b - a, axis=1)
    along = np.einsum("fi,fi->f", c - a, b - a) / base
    height = np.linalg.norm(c - a - (along / base)[:, None] * (b - a), axis=1)
    corners = np.stack([base, along, height], axis=1)
    faces = np.ascontiguousarray(mesh.faces)
    return Charts(faces, corners, _neighbours(mesh), *mesh.incident_faces)


def _neighbours(mesh: TriangleMesh) -> IntArray:
    """(F, 3) triangle beyond the edge opposite each corner, or -1."""
    sides = mesh.face_edges.of_side.ravel()
    order = np.argsort(sides, kind="stable")
    one, other = order[mesh.face_edges.counts[sides[order]] == 2].reshape(-1, 2).T
    beyond = np.full(len(sides), -1, dtype=np.int64)
    beyond[one], beyond[other] = other // 3, one // 3
    # The side opposite a corner starts at the next one.
    return np.roll(beyond.reshape(-1, 3), -1, axis=1)
