"""Nearest points by a tree against all triangles, and where they are known."""

import numpy as np
import trimesh

from solver.mesh import face_normals, surface_tree
from tests.solver import shapes


def test_distances_are_those_to_the_nearest_of_all_triangles() -> None:
    mesh = shapes.blob(2)
    points = np.random.default_rng(0).normal(size=(200, 3)) * 2.0
    corners = mesh.vertices[mesh.faces]
    every = []
    for point in points:
        repeated = np.tile(point, (len(corners), 1))
        places = trimesh.triangles.closest_point(corners, repeated)  # type: ignore[no-untyped-call]
        every.append(np.linalg.norm(places - point, axis=1).min())
    tree = surface_tree(mesh.vertices, mesh.faces)
    np.testing.assert_allclose(tree.distances(points), every, atol=1e-12)
    faces, weights = tree.nearest(points)
    assert weights.min() >= 0.0
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    nearest = np.einsum("nc,ncd->nd", weights, corners[faces])
    np.testing.assert_allclose(np.linalg.norm(nearest - points, axis=1), every, atol=1e-12)


def test_the_centre_of_a_triangle_is_on_it_with_its_own_normal() -> None:
    mesh = shapes.blob(2)
    normals = face_normals(mesh.vertices, mesh.faces)
    tree = surface_tree(mesh.vertices, mesh.faces)
    centres = mesh.vertices[mesh.faces].mean(axis=1)
    least, greatest = tree.cosines(centres, normals)
    np.testing.assert_allclose(least, np.linalg.norm(normals, axis=1))
    np.testing.assert_allclose(greatest, least)


def test_a_point_beyond_an_edge_has_the_normals_of_both_sides() -> None:
    mesh = shapes.cube(2)
    tree = surface_tree(mesh.vertices, mesh.faces)
    least, greatest = tree.cosines(np.array([[2.0, 0.3, 2.0]]), np.array([[1.0, 0.0, 0.0]]))
    np.testing.assert_allclose([least[0], greatest[0]], [0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(tree.distances(np.array([[2.0, 0.3, 2.0]])), np.sqrt(2.0))


def test_a_surface_of_one_triangle_has_a_tree() -> None:
    tree = surface_tree(np.eye(3), np.array([[0, 1, 2]]))
    np.testing.assert_allclose(tree.distances(np.zeros((1, 3))), 1.0 / np.sqrt(3.0))
