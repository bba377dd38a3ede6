"""Vertices as points of triangles."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.mesh.triangle_mesh import TriangleMesh


def at_vertices(mesh: TriangleMesh, vertices: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the triangles that vertices are corners of, and where in these they are.

    Parameters
    ----------
    mesh
        The mesh.
    vertices
        (N,) vertices. Of the triangles that share one, the first is taken.

    Returns
    -------
    (N,) triangles and (N, 3) barycentric coordinates.
    """
    corners = mesh.faces.ravel()
    first = np.full(mesh.n_vertices, len(corners), dtype=np.int64)
    np.minimum.at(first, corners, np.arange(len(corners)))
    faces, corner = np.divmod(first[vertices], 3)
    return faces, np.eye(3)[corner]
