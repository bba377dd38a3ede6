"""Signed volumes: closed forms, signs, and invariances."""

from itertools import permutations

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.mesh import TriangleMesh, triangle_mesh
from solver.shape import Shape, signed_volumes
from tests.solver import shapes

VERTICES = np.array([0, 57, 121, 300, 411])


def volumes_of(mesh: TriangleMesh, vertices: IntArray) -> FloatArray:
    shape = Shape(mesh)
    return signed_volumes(shape.surface, shape.metric("commute_time").distances(vertices))


def test_coordinates_enclose_the_volume_of_the_body() -> None:
    cube = shapes.cube()
    assert signed_volumes(cube, cube.vertices.T)[0, 1, 2] == pytest.approx(1.0)
    sphere = shapes.icosphere(4)
    volume = signed_volumes(sphere, sphere.vertices.T)[0, 1, 2]
    assert volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.01)


def test_a_linear_map_multiplies_by_its_determinant() -> None:
    blob = shapes.blob()
    matrix = np.random.default_rng(1).normal(size=(3, 3))
    before = signed_volumes(blob, blob.vertices.T)[0, 1, 2]
    after = signed_volumes(blob, matrix @ blob.vertices.T)[0, 1, 2]
    assert after == pytest.approx(np.linalg.det(matrix) * before)


def test_functions_of_two_others_enclose_nothing() -> None:
    blob = shapes.blob()
    x, y, _ = blob.vertices.T
    assert signed_volumes(blob, np.stack([x, y, 2.0 * x - y + 3.0]))[0, 1, 2] == pytest.approx(
        0.0, abs=1e-12
    )


@pytest.mark.parametrize("mesh", [shapes.blob(), shapes.disc()], ids=["closed", "open"])
def test_exchange_of_two_points_changes_the_sign(mesh: TriangleMesh) -> None:
    found = volumes_of(mesh, VERTICES)
    for order in permutations(range(3)):
        parity = np.linalg.det(np.eye(3)[list(order)])
        np.testing.assert_allclose(found, parity * found.transpose(order), atol=1e-13)
    assert np.abs(found).max() > 1e-6


def test_winding_and_reflection_change_the_sign() -> None:
    blob = shapes.blob()
    shape = Shape(blob)
    distances = shape.metric("commute_time").distances(VERTICES)
    surface = shape.surface
    found = signed_volumes(surface, distances)
    turned = TriangleMesh(surface.vertices, surface.faces[:, ::-1], surface.vertex_ids)
    np.testing.assert_allclose(signed_volumes(turned, distances), -found, atol=1e-13)
    # Repair winds the reflected surface so that its normals point outwards, like those of the blob.
    reflected = triangle_mesh(blob.vertices * [-1.0, 1.0, 1.0], blob.faces)
    np.testing.assert_allclose(volumes_of(reflected, VERTICES), -found, atol=1e-8)


def test_motion_scale_and_order_of_vertices_change_nothing() -> None:
    blob = shapes.blob()
    found = volumes_of(blob, VERTICES)
    # A rotation: an orthogonal matrix with a reflection would change the sign.
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    moved = triangle_mesh(3.0 * blob.vertices @ turn + 1.0, blob.faces)
    np.testing.assert_allclose(volumes_of(moved, VERTICES), found, atol=1e-8)
    mixed, where = shapes.permuted(blob, seed=4)
    np.testing.assert_allclose(volumes_of(mixed, where[VERTICES]), found, atol=1e-8)
