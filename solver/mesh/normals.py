"""Normals and areas of triangles, and normals at vertices."""

import numpy as np

from solver.arrays import FloatArray, IntArray


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


def triangle_areas(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Areas of triangles.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (F, 3).

    Returns
    -------
    (F,) float64, in squared units of length.
    """
    areas: FloatArray = 0.5 * np.linalg.norm(face_normals(vertices, faces), axis=1)
    return areas


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
