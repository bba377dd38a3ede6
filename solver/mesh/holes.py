"""Holes of a surface, closed."""

import numpy as np

from solver.arrays import IntArray
from solver.errors import MeshError
from solver.mesh.repair import holes_of
from solver.mesh.triangle_mesh import TriangleMesh, triangle_mesh


def with_holes_closed(mesh: TriangleMesh) -> TriangleMesh | None:
    """Close each hole by a fan of triangles round the mean of its boundary.

    Parameters
    ----------
    mesh
        V vertices. Boundaries that share a vertex are one hole.

    Returns
    -------
    TriangleMesh
        ``vertex_ids`` are places among the V vertices, and V and more for the middles of the fans.
        ``None`` if there is no hole, or no sound surface comes of it.
    """
    if mesh.closed:
        return None
    faces, sides = mesh.boundary_sides
    start, end = mesh.faces[faces, sides], mesh.faces[faces, (sides + 1) % 3]
    hole, middles = holes_of(mesh.vertices, start, end, np.zeros_like(start))
    # Fans run along the boundary against the faces that they meet there.
    fans: IntArray = np.stack([end, start, mesh.n_vertices + hole], axis=1)
    try:
        return triangle_mesh(
            np.concatenate([mesh.vertices, middles]), np.concatenate([mesh.faces, fans])
        )
    except MeshError:
        return None
