"""Damages that leave no surface to speak of."""

from collections.abc import Mapping

import numpy as np

from solver.mesh import TriangleMesh
from tests.solver.mesh.repair.damage.damaged import Damage, Damaged, damaged_mesh, with_points


def not_a_number(mesh: TriangleMesh) -> Damaged:
    vertices = mesh.vertices.copy()
    vertices[33, 1] = np.nan
    return damaged_mesh(mesh, vertices)


def infinite(mesh: TriangleMesh) -> Damaged:
    vertices = mesh.vertices.copy()
    vertices[44, 2] = np.inf
    return damaged_mesh(mesh, vertices)


def on_a_line(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, mesh.vertices * np.array([1.0, 0.0, 0.0]))


def in_a_point(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, mesh.vertices * 0.0 + 3.0)


def in_a_point_but_for_a_face_with_a_corner_twice(mesh: TriangleMesh) -> Damaged:
    vertices = with_points(mesh, np.zeros(3))
    vertices[:-1] = 3.0
    return damaged_mesh(
        mesh, vertices, [*mesh.faces.tolist(), [0, mesh.n_vertices, mesh.n_vertices]]
    )


def beyond_numbers(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, mesh.vertices * 1e90)


def below_numbers(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, mesh.vertices * 1e-90)


def lost_in_single_precision(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, (3e1 * mesh.vertices + 1e8).astype(np.float32).astype(np.float64))


def lost_in_six_digits(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, np.round(mesh.vertices + 1e5, 0))


def a_vertex_too_far(mesh: TriangleMesh) -> Damaged:
    return damaged_mesh(mesh, faces=[*mesh.faces.tolist(), [0, 1, mesh.n_vertices]])


REFUSED: Mapping[Damage, str] = {
    not_a_number: "vertex 33 has a coordinate that is not a finite number",
    infinite: "vertex 44 has a coordinate that is not a finite number",
    on_a_line: "no face has an area",
    in_a_point: "no extent",
    in_a_point_but_for_a_face_with_a_corner_twice: "no extent",
    beyond_numbers: "too large or too small",
    below_numbers: "too large or too small",
    lost_in_single_precision: "its details are lost; move it to the origin",
    lost_in_six_digits: "its details are lost; move it to the origin",
    a_vertex_too_far: "refers to vertex 642",
}
"""There is no surface to speak of; with the reason that the user is given."""
