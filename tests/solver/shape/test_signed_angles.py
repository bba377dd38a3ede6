"""Signed angles: a closed form in the plane, signs, and invariances."""

from itertools import permutations

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import SIGNED_ANGLE_RADIUS, Shape, signed_angles
from tests.solver import shapes

VERTICES = np.array([0, 57, 121, 300, 411])


def angles_of(mesh: TriangleMesh, vertices: IntArray) -> FloatArray:
    shape = Shape(mesh)
    distances = shape.metric("geodesic").distances(vertices)
    return signed_angles(shape.surface, distances, SIGNED_ANGLE_RADIUS)


def test_sines_of_the_angles_of_a_plane_triangle() -> None:
    """Discs of radius r see the other corners in nearly one direction each."""
    plane, radius = shapes.plane_grid(121, 81), 0.03
    corners = np.array([[0.3, 0.3, 0.0], [1.2, 0.4, 0.0], [0.7, 0.8, 0.0]])
    places = np.array(
        [np.linalg.norm(plane.vertices - corner, axis=1).argmin() for corner in corners]
    )
    points = plane.vertices[places]
    distances = np.linalg.norm(points[:, None] - plane.vertices[None], axis=2)
    found = signed_angles(plane, distances, radius)
    sides = [points[(k + 1) % 3] - points[k] for k in range(3)]
    sines = [
        np.cross(sides[k], -sides[k - 1])[2]
        / (np.linalg.norm(sides[k]) * np.linalg.norm(sides[k - 1]))
        for k in range(3)
    ]
    assert min(sines) > 0.0  # counterclockwise
    winding = np.sign(np.cross(*np.diff(plane.vertices[plane.faces[0]], axis=0))[2])
    expected = winding * np.pi * radius**2 * sum(sines) / 3.0
    assert found[0, 1, 2] == pytest.approx(expected, rel=0.02)


def test_exchange_of_two_points_changes_the_sign() -> None:
    found = angles_of(shapes.blob(), VERTICES)
    for order in permutations(range(3)):
        parity = np.linalg.det(np.eye(3)[list(order)])
        np.testing.assert_allclose(found, parity * found.transpose(order), atol=1e-15)
    assert (np.abs(found[np.triu_indices(5, 1)]).max(axis=1) > 0.0).all()


def test_winding_and_reflection_change_the_sign() -> None:
    blob = shapes.blob()
    shape = Shape(blob)
    distances = shape.metric("geodesic").distances(VERTICES)
    surface = shape.surface
    found = signed_angles(surface, distances, SIGNED_ANGLE_RADIUS)
    turned = TriangleMesh(surface.vertices, surface.faces[:, ::-1], surface.vertex_ids)
    reverse = signed_angles(turned, distances, SIGNED_ANGLE_RADIUS)
    np.testing.assert_allclose(reverse, -found, atol=1e-15)
    # Repair winds the reflected surface so that its normals point outwards, like those of the blob.
    reflected = triangle_mesh(blob.vertices * [-1.0, 1.0, 1.0], blob.faces)
    np.testing.assert_allclose(angles_of(reflected, VERTICES), -found, atol=1e-12)


def test_motion_scale_and_order_of_vertices_change_nothing() -> None:
    blob = shapes.blob()
    found = angles_of(blob, VERTICES)
    moved = angles_of(shapes.moved(blob, seed=2, scale=3.0), VERTICES)
    np.testing.assert_allclose(moved, found, atol=1e-9)
    mixed, where = shapes.permuted(blob, seed=4)
    np.testing.assert_allclose(angles_of(mixed, where[VERTICES]), found, atol=1e-9)
