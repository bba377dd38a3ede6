"""Texture coordinates carried along a map: the triangles of Y get places in the image of X.

A texture is continuous but for its seams, where X is cut: a vertex there has other coordinates in
the triangles of either side. Each triangle of Y is put on the side that its centre is mapped to.
Its corners go from there to their images without crossing a seam, as far as they get, so that no
triangle is stretched over parts of the image that do not belong together.
"""

from dataclasses import dataclass, replace

import numpy as np

from solver.arrays import BoolArray, FloatArray, IntArray
from solver.mesh import TriangleMesh, descend, project
from solver.mesh.textures import Paint
from solver.registration import DenseCorrespondence
from solver.transfer.landmarks import Landmarks, surface_images
from solver.transfer.overlap import mapped_faces

_CENTRE = np.full(3, 1.0 / 3.0)


def carried_paint(
    target: TriangleMesh, dense: DenseCorrespondence, source: TriangleMesh, paint: Paint
) -> Paint:
    """Carry texture coordinates of X to Y.

    Parameters
    ----------
    target
        The surface Y.
    dense
        The map Y → X.
    source
        The surface X with all faces of its file: :func:`solver.mesh.textured_surface`.
    paint
        Texture coordinates and textures of its faces.

    Returns
    -------
    Those of the faces of Y. Faces without texture have the colours of those that their centres are
    mapped to; black with a corner that is not mapped.
    """
    coordinates = np.zeros((target.n_faces, 3, 2))
    colors = np.zeros((target.n_faces, 3))
    texture = np.full(target.n_faces, -1, dtype=np.int64)
    light = np.ones((target.n_faces, 3))
    known, faces = faces_at_centres(target, dense, source)
    corners = target.vertex_ids[target.faces[known]]
    colors[known], texture[known] = paint.colors[faces], paint.texture_of_face[faces]
    if paint.light is not None:
        light[known] = paint.light[faces]
    textured = texture[known] >= 0
    ends = _images(corners[textured].ravel(), dense, source)
    coordinates[known[textured]] = _on_one_side(faces[textured], ends, source, paint)
    found = Paint(coordinates, colors, texture, paint.textures, light)
    return with_materials(found, paint, known, faces)


def faces_at_centres(
    target: TriangleMesh, dense: DenseCorrespondence, source: TriangleMesh
) -> tuple[IntArray, IntArray]:
    """Map the centres of triangles of Y to X.

    Parameters
    ----------
    target, dense, source
        As for :func:`carried_paint`.

    Returns
    -------
    (n,) triangles of Y whose corners are mapped, and (n,) those of X that their centres lie in.
    """
    known = mapped_faces(target, dense)
    corners = target.vertex_ids[target.faces[known]]
    centres = Landmarks(corners, np.tile(_CENTRE, (len(known), 1)))
    return known, surface_images(centres, dense, source)[0]


def with_materials(found: Paint, paint: Paint, known: IntArray, faces: IntArray) -> Paint:
    """Return the paint of Y with the materials of X.

    Parameters
    ----------
    found, paint
        Of Y, and of X.
    known, faces
        As :func:`faces_at_centres` returns them.
    """
    if paint.material_of_face is None:
        return found
    materials = np.full(len(found.texture_of_face), -1, dtype=np.int64)
    materials[known] = paint.material_of_face[faces]
    return replace(found, material_of_face=materials, materials=paint.materials)


@dataclass(frozen=True, eq=False)
class _Places:
    """Points of X: (n,) faces, and (n, 3) barycentric coordinates there."""

    faces: IntArray
    shares: FloatArray

    def positions(self, source: TriangleMesh) -> FloatArray:
        """(n, 3) in space."""
        corners = source.vertices[source.faces[self.faces]]
        found: FloatArray = np.einsum("nc,ncd->nd", self.shares, corners)
        return found


def _images(vertices: IntArray, dense: DenseCorrespondence, source: TriangleMesh) -> _Places:
    """Images of vertices of Y, by the user's numbers: the same for each time one is named."""
    corner = np.repeat(dense.source[:, None], 3, axis=1)
    points = Landmarks(corner, np.tile([1.0, 0.0, 0.0], (len(corner), 1)))
    faces, shares = surface_images(points, dense, source)
    rows = np.searchsorted(dense.source, vertices)
    return _Places(faces[rows], shares[rows])


def _on_one_side(sides: IntArray, ends: _Places, source: TriangleMesh, paint: Paint) -> FloatArray:
    """(n, 3, 2) coordinates of triangles, from n faces of X and 3 n images of corners, their ends.

    A path leads from the face towards each end and crosses no seam. An end that it comes to has its
    own coordinates; others have those of the point nearest to them where the path stops.
    """
    textured = np.flatnonzero(paint.texture_of_face >= 0)
    cut = _cut_along_seams(textured, source, paint)
    number = np.full(source.n_faces, -1)
    number[textured] = np.arange(len(textured))
    places, there = ends.positions(source), number[ends.faces]
    begin = cut.faces[number[np.repeat(sides, 3)]]
    apart = np.linalg.norm(cut.vertices[begin] - places[:, None], axis=2)
    start = begin[np.arange(len(begin)), apart.argmin(axis=1)]
    stops = descend(places, cut.vertices, *cut.edge_neighbours, start)
    reached = (there >= 0) & _beside(cut, stops, cut.faces[there])
    nearest, weights = project(places, cut.vertices, cut.faces, *cut.incident_faces, stops)
    faces = np.where(reached, ends.faces, textured[nearest])
    shares = np.where(reached[:, None], ends.shares, weights)
    coordinates: FloatArray = np.einsum("nc,ncd->nd", shares, paint.coordinates[faces])
    return coordinates.reshape(-1, 3, 2)


def _beside(cut: TriangleMesh, vertices: IntArray, corners: IntArray) -> BoolArray:
    """(n,) whether vertices are, or are joined by an edge to, one of three corners each."""
    base = np.array([cut.n_vertices, 1])
    pairs = np.sort(np.stack(np.broadcast_arrays(vertices[:, None], corners), axis=2), axis=2)
    joined = np.isin(pairs @ base, cut.edges @ base) | (corners == vertices[:, None])
    found: BoolArray = joined.any(axis=1)
    return found


def _cut_along_seams(textured: IntArray, source: TriangleMesh, paint: Paint) -> TriangleMesh:
    """Some faces of X, cut along its seams.

    Corners are one vertex there if they are one on X, with the same texture and coordinates.
    """
    vertices = source.faces[textured].ravel()
    texture = np.repeat(paint.texture_of_face[textured], 3)
    table = np.column_stack([vertices, texture, paint.coordinates[textured].reshape(-1, 2)])
    _, first, inverse = np.unique(table, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1, 3).astype(np.int64)
    return TriangleMesh(source.vertices[vertices[first]], faces, np.arange(len(first)))
