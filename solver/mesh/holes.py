"""Holes of a surface, closed."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import MeshError
from solver.mesh.repair import components_of
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
    faces, sides = mesh.soup().edges.boundary_sides
    if not len(faces):
        return None
    start, end = mesh.faces[faces, sides], mesh.faces[faces, (sides + 1) % 3]
    component = components_of(np.stack([start, end], axis=1), mesh.n_vertices)
    hole = np.unique(component[start], return_inverse=True)[1]
    size = np.bincount(hole)
    middles: FloatArray = np.stack(
        [np.bincount(hole, one) / size for one in mesh.vertices[start].T], axis=1
    )
    # Fans run along the boundary against the faces that they meet there.
    fans: IntArray = np.stack([end, start, mesh.n_vertices + hole], axis=1)
    try:
        return triangle_mesh(
            np.concatenate([mesh.vertices, middles]), np.concatenate([mesh.faces, fans])
        )
    except MeshError:
        return None
