"""Vertices and faces in another order, and vertices of no face."""

from collections.abc import Mapping

import numpy as np

from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import (
    Damage,
    Damaged,
    damaged_mesh,
    generator,
    with_points,
)


def vertices_shuffled(mesh: TriangleMesh) -> Damaged:
    where = generator().permutation(mesh.n_vertices)
    vertices = np.empty_like(mesh.vertices)
    vertices[where] = mesh.vertices
    return Damaged(vertices, where[mesh.faces].tolist(), where)


def faces_shuffled(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, faces=generator().permutation(mesh.faces))


def corners_rotated(mesh: TriangleMesh) -> Damaged:
    shift = generator().integers(0, 3, mesh.n_faces)[:, None]
    return damaged_mesh(
        mesh, faces=np.take_along_axis(mesh.faces, (np.arange(3) + shift) % 3, axis=1)
    )


def unused_vertices_between(mesh: TriangleMesh) -> Damaged:
    where = 3 * np.arange(mesh.n_vertices) + 2
    vertices = np.full((3 * mesh.n_vertices, 3), 0.123)
    vertices[where] = mesh.vertices
    return Damaged(vertices, where[mesh.faces].tolist(), where)


def unused_vertices_far_away(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, with_points(mesh, [1e300, -1e300, 0.0], [1e9, 0.0, 0.0]))


def unused_vertices_without_place(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, with_points(mesh, [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0]))


TOLD: Mapping[Damage, str] = {
    vertices_shuffled: "",
    faces_shuffled: "",
    corners_rotated: "",
    unused_vertices_between: "dropped 1284 vertices that no face uses",
    unused_vertices_far_away: "dropped 2 vertices that no face uses",
    unused_vertices_without_place: "dropped 2 vertices that no face uses",
}
"""With what the user is told."""
