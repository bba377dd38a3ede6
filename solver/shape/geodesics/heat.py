"""The heat method (Crane, Weischedel and Wardetzky, ACM TOG 32(5), 2013), by potpourri3d.

Algorithm 1 of the paper: heat flows from the source for a short time t; its normalised gradient
approximates that of the distance, which follows from a Poisson equation. Both linear systems are
factored once for all sources, on the tufted intrinsic Delaunay triangulation (Sharp and Crane, SGP
2020): on the triangles as they are, the method errs by tens of per cent where these are thin.
"""

import numpy as np
import potpourri3d

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh import TriangleMesh
from solver.shape.geodesics.interface import checked_sources

_TIME = 1.0
"""Time t of the heat flow, in squared mean edge lengths (section 3.2.4 of the paper)."""


class HeatMethod:
    """Smooth geodesic distances by the heat method.

    Parameters
    ----------
    mesh
        Any mesh.

    Raises
    ------
    MeshError
        The Laplacian of the mesh is singular or not finite.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._count = mesh.n_vertices
        try:
            self._solver = potpourri3d.MeshHeatMethodDistanceSolver(
                mesh.vertices, _bridged_faces(mesh), t_coef=_TIME, use_robust=True
            )
        except RuntimeError as error:
            raise MeshError(f"the heat method fails on this mesh: {error}") from error

    @property
    def n_vertices(self) -> int:
        """Number V of vertices."""
        return self._count

    def distances(self, sources: IntArray) -> FloatArray:
        """(S, V) smooth distances from (S,) vertices to all; two back substitutions per source.

        Raises
        ------
        MeshError
            The linear systems are singular to working precision.
        """
        known = checked_sources(sources, self.n_vertices)
        found = np.empty((len(known), self.n_vertices))
        for row, source in zip(found, known, strict=True):
            row[:] = self._solver.compute_distance(int(source))
            if not np.isfinite(row).all():
                raise MeshError("the heat method fails on this mesh: its faces are nearly flat")
            np.maximum(row - row[source], 0.0, out=row)
        return found


def _bridged_faces(mesh: TriangleMesh) -> IntArray:
    """(F + L, 3) faces, and a triangle for each link: heat flows over faces only."""
    first, neighbours = mesh.incident_faces
    start, end = mesh.links.T
    ring = mesh.faces[neighbours[first[start]]]
    own = ring != start[:, None]
    third = ring[np.arange(len(ring)), np.argmax(own, axis=1)]
    return np.concatenate([mesh.faces, np.stack([start, end, third], axis=1)])
