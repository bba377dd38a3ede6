"""Welding: seams close, and surfaces that only touch stay apart."""

import numpy as np
import pytest

from solver.mesh import triangle_mesh
from tests.solver import shapes
from tests.solver.mesh.repair.damage import read, seams


def test_all_names_of_merged_vertices_lead_to_the_same_vertex() -> None:
    original, damaged = shapes.blob(3), seams.loose_faces(shapes.blob(3))
    mesh = read(damaged)
    numbers = np.array(damaged.faces)
    np.testing.assert_array_equal(
        mesh.vertices_of(numbers.reshape(-1)), mesh.faces[:, :].reshape(-1)
    )
    assert mesh.n_vertices == original.n_vertices
    assert mesh.vertices_of(np.array([-1, numbers.max() + 1])).tolist() == [-1, -1]


def test_surfaces_that_touch_in_a_point_stay_apart() -> None:
    """Coinciding corners of the boundary are no seam, nor is a corner that touches a side."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    for step in ([1.0, 1.0, 0.0], [1.0, 0.5, 1e-9]):
        turned = square @ np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
        vertices = np.concatenate([square, turned + np.array(step)])
        mesh = triangle_mesh(vertices, np.concatenate([faces, faces + 4]))
        assert (mesh.components, mesh.n_vertices, mesh.n_faces) == (2, 8, 4)


def test_walls_between_touching_solids_stay() -> None:
    """Two cubes side by side share a wall, but neither is a copy of the other."""
    cube = shapes.cube(3)
    beside = cube.vertices + np.array([1.0, 0.0, 0.0])
    mesh = triangle_mesh(
        np.concatenate([cube.vertices, beside]),
        np.concatenate([cube.faces, cube.faces + cube.n_vertices]),
    )
    assert [warning[:24] for warning in mesh.warnings] == ["2 components are linked "]
    assert (mesh.components, mesh.closed) == (2, True)
    assert mesh.area == pytest.approx(12.0)
