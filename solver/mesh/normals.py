"""Normals of triangulated surfaces."""

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.kernel import kernel


def face_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Normals of triangles, of length twice the area.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (F, 3).

    Returns
    -------
    (F, 3) float64, in squared units of length.
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def vertex_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Unit normals at vertices: the mean over the triangles around, by area.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (F, 3).

    Returns
    -------
    (V, 3) float64; 0 where triangles cancel out, or where there are none.
    """
    normals, corners = face_normals(vertices, faces), faces.ravel()
    summed = np.stack(
        [np.bincount(corners, np.repeat(normals[:, d], 3), len(vertices)) for d in range(3)],
        axis=1,
    )
    unit: FloatArray = summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), 1e-300)
    return unit


@kernel
def signed_areas(
    positions: FloatArray, normals: FloatArray, a: IntArray, b: IntArray, c: IntArray
) -> FloatArray:
    """Twice the areas of triangles, as seen along the normal at the first corner.

    Parameters
    ----------
    positions, normals
        (V, 3) of vertices.
    a, b, c
        (T,) corners of the triangles.

    Returns
    -------
    (T,) float64, negative where the corners go round clockwise.
    """
    areas = np.empty(len(a))
    for place in range(len(a)):
        corner, one, two = positions[a[place]], positions[b[place]], positions[c[place]]
        x, y, z = normals[a[place]]
        ux, uy, uz = one[0] - corner[0], one[1] - corner[1], one[2] - corner[2]
        vx, vy, vz = two[0] - corner[0], two[1] - corner[1], two[2] - corner[2]
        areas[place] = x * (uy * vz - uz * vy) + y * (uz * vx - ux * vz) + z * (ux * vy - uy * vx)
    return areas
