"""Cuts along which a surface was given two boundaries, some of which gape."""

from collections.abc import Mapping

import numpy as np

from solver.arrays import IntArray
from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import Damage, Damaged, centroids, generator, jittered


def _cut(mesh: TriangleMesh, side: IntArray) -> Damaged:
    """Give the faces of each side vertices of their own."""
    key = mesh.faces + mesh.n_vertices * side[:, None]
    used, faces = np.unique(key, return_inverse=True)
    where = np.full(mesh.n_vertices, -1)
    where[(used % mesh.n_vertices)[::-1]] = np.arange(len(used))[::-1]
    return Damaged(mesh.vertices[used % mesh.n_vertices], faces.reshape(-1, 3).tolist(), where)


def a_seam(mesh: TriangleMesh) -> Damaged:
    return _cut(mesh, (centroids(mesh)[:, 0] > 0.1).astype(np.int64))


def crossing_seams(mesh: TriangleMesh) -> Damaged:
    return _cut(mesh, (centroids(mesh) > 0.1) @ np.array([1, 2, 4]))


def an_open_seam(mesh: TriangleMesh) -> Damaged:
    """A cut that ends within the surface."""
    x, y, z = centroids(mesh).T
    return _cut(mesh, ((x > 0.1) & (y > 0.1) & (z > 0.1)).astype(np.int64))


def loose_faces(mesh: TriangleMesh) -> Damaged:
    return _cut(mesh, np.arange(mesh.n_faces))


def loose_faces_turned_at_random(mesh: TriangleMesh) -> Damaged:
    damaged = loose_faces(mesh)
    turned = generator().random(mesh.n_faces) < 0.4
    faces = [face[::-1] if turn else face for face, turn in zip(damaged.faces, turned, strict=True)]
    return Damaged(damaged.vertices, faces, damaged.where)


def a_seam_that_gapes(mesh: TriangleMesh) -> Damaged:
    return jittered(a_seam(mesh), 1e-6)


def loose_faces_that_gape(mesh: TriangleMesh) -> Damaged:
    return jittered(loose_faces(mesh), 1e-6)


def a_seam_in_six_digits(mesh: TriangleMesh) -> Damaged:
    """One side written with six digits, the other with all."""
    damaged = a_seam(mesh)
    vertices = damaged.vertices.copy()
    rounded = vertices[:, 1] > 0.0
    vertices[rounded] = np.round(vertices[rounded], 6)
    return Damaged(vertices, damaged.faces, damaged.where)


TOLD: Mapping[Damage, str] = {
    a_seam: "closed seams",
    crossing_seams: "closed seams",
    an_open_seam: "closed seams",
    loose_faces: "closed seams: merged 3198 boundary vertices",
    loose_faces_turned_at_random: "to agree with neighbouring faces",
    a_seam_that_gapes: "closed seams",
    loose_faces_that_gape: "closed seams",
    a_seam_in_six_digits: "closed seams",
}
"""With what the user is told."""
