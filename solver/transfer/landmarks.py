"""Images of points of a surface: landmarks, which go along the map X → Y themselves."""

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.errors import TransferError
from solver.mesh import TriangleMesh, descend, project
from solver.registration import DenseCorrespondence


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Points in the triangles of a surface, by the numbers of its vertices in the file.

    Parameters
    ----------
    corners
        (n, 3) corners of each triangle, by the user's numbers. A vertex may stand for all three.
    barycentric
        (n, 3) barycentric coordinates, none negative; each row sums to 1. Of a missing point,
        corners are -1 and coordinates nan.
    """

    corners: IntArray
    barycentric: FloatArray

    @staticmethod
    def at_rows(rows: IntArray, points: "Landmarks", count: int) -> "Landmarks":
        """Return `count` points, of which some rows are known and the others missing."""
        corners = np.full((count, 3), -1, dtype=np.int64)
        barycentric = np.full((count, 3), np.nan)
        corners[rows], barycentric[rows] = points.corners, points.barycentric
        return Landmarks(corners, barycentric)

    def at(self, rows: IntArray | BoolArray) -> "Landmarks":
        """Return the points of some rows."""
        return Landmarks(self.corners[rows], self.barycentric[rows])

    def among(self, vertices: IntArray) -> BoolArray:
        """(n,) whether all corners of the triangle of each point are among vertices."""
        found: BoolArray = np.all(np.isin(self.corners, vertices), axis=1)
        return found

    def positions(self, mesh: TriangleMesh) -> FloatArray:
        """(n, 3) positions in space; nan of missing points, and of those with an unknown corner."""
        rows = mesh.vertices_of(self.corners)
        found: FloatArray = np.einsum("nc,ncd->nd", self.barycentric, mesh.vertices[rows])
        found[(rows < 0).any(axis=1)] = np.nan
        return found


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
    faces, barycentric = surface_images(points, dense, target)
    corners = target.vertex_ids[target.faces[faces]]
    # Vertices have images of their own, which need not be those of their neighbourhood.
    chosen = points.barycentric.argmax(axis=1)
    every = np.arange(len(chosen))
    at_vertex = points.barycentric[every, chosen] > 1.0 - 1e-9
    rows = _rows(dense, points.corners[every, chosen][at_vertex])
    corners[at_vertex] = dense.faces[rows]
    barycentric[at_vertex] = dense.barycentric[rows]
    return Landmarks(corners, barycentric)


def surface_images(
    points: Landmarks, dense: DenseCorrespondence, target: TriangleMesh
) -> tuple[IntArray, FloatArray]:
    """Map points of X to Y by the images of the corners alone.

    Parameters
    ----------
    points, dense, target
        As for :func:`landmark_images`.

    Returns
    -------
    (n,) faces of the target, and (n, 3) barycentric coordinates there.

    Raises
    ------
    TransferError
        As for :func:`landmark_images`.
    """
    weights = points.barycentric
    if (weights < 0.0).any() or (np.abs(weights.sum(axis=1) - 1.0) > 1e-3).any():
        raise TransferError("barycentric coordinates must not be negative, and their sum is 1")
    # Samples share corners: the image of each is computed once.
    rows, of_corner = np.unique(_rows(dense, points.corners), return_inverse=True)
    triangles, shares = target.vertices_of(dense.faces[rows]), dense.barycentric[rows]
    images = np.einsum("kb,kbd->kd", shares, target.vertices[triangles])
    means = np.einsum("nc,ncd->nd", weights / weights.sum(axis=1, keepdims=True), images[of_corner])
    # Descent in space begins at the image of the nearest corner, so that it stays on its limb.
    main = triangles[np.arange(len(rows)), shares.argmax(axis=1)]
    start = main[of_corner[np.arange(len(weights)), weights.argmax(axis=1)]]
    nearest = descend(means, target.vertices, *target.neighbours, start)
    return project(means, target.vertices, target.faces, *target.incident_faces, nearest)


def _rows(dense: DenseCorrespondence, vertices: IntArray) -> IntArray:
    """Rows of a map that hold vertices of X."""
    rows: IntArray = np.searchsorted(dense.source, vertices).clip(max=len(dense.source) - 1)
    unknown = vertices[dense.source[rows] != vertices]
    if unknown.size:
        raise TransferError(f"vertex {unknown[0]} is not part of the mapped surface")
    return rows
