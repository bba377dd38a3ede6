"""Images of points of a surface: landmarks, which go along the map X → Y themselves."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.errors import TransferError
from solver.mesh import TriangleMesh
from solver.registration import DenseCorrespondence, descend, project


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Points in the triangles of a surface, by the numbers of its vertices in the file.

    Parameters
    ----------
    corners
        (n, 3) corners of each triangle, by the user's numbers. A vertex may stand for all three.
    barycentric
        (n, 3) barycentric coordinates, none negative; each row sums to 1.
    """

    corners: IntArray
    barycentric: FloatArray


def landmark_images(
    points: Landmarks, dense: DenseCorrespondence, target: TriangleMesh
) -> Landmarks:
    """Map points of X to Y.

    The image of a vertex is that of the map. The image of another point is the point of Y nearest
    to the barycentric mean of the images of its triangle's corners, near these.

    Parameters
    ----------
    points
        Of X.
    dense
        The map X → Y.
    target
        The surface Y.

    Raises
    ------
    TransferError
        A corner is no vertex of the mapped surface, or coordinates are negative or of another sum.
    """
    weights = points.barycentric
    if (weights < 0.0).any() or (np.abs(weights.sum(axis=1) - 1.0) > 1e-3).any():
        raise TransferError("barycentric coordinates must not be negative, and their sum is 1")
    rows = np.searchsorted(dense.source, points.corners).clip(max=len(dense.source) - 1)
    unknown = points.corners[dense.source[rows] != points.corners]
    if unknown.size:
        raise TransferError(f"vertex {unknown[0]} is not part of the mapped surface")
    triangles = target.vertices_of(dense.faces[rows].ravel()).reshape(*rows.shape, 3)
    images = np.einsum("ncb,ncbd->ncd", dense.barycentric[rows], target.vertices[triangles])
    means = np.einsum("nc,ncd->nd", weights / weights.sum(axis=1, keepdims=True), images)
    chosen = weights.argmax(axis=1)
    every = np.arange(len(rows))
    # Descent in space begins at the image of the nearest corner, so that it stays on its limb.
    main = dense.barycentric[rows[every, chosen]].argmax(axis=1)
    start = triangles[every, chosen, main]
    nearest = descend(means, target.vertices, *target.neighbours, start)
    faces, barycentric = project(
        means, target.vertices, target.faces, *target.incident_faces, nearest
    )
    corners = target.vertex_ids[target.faces[faces]]
    at_vertex = weights.max(axis=1) > 1.0 - 1e-9
    vertex_rows = rows[every, chosen][at_vertex]
    corners[at_vertex] = dense.faces[vertex_rows]
    barycentric[at_vertex] = dense.barycentric[vertex_rows]
    return Landmarks(corners, barycentric)
