"""Images of points of a surface."""

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.errors import TransferError
from solver.mesh import TriangleMesh
from solver.transfer import Landmarks, landmark_images
from tests.solver import shapes
from tests.solver.transfer.maps import FINE, MESH, registered

RANDOM = np.random.default_rng(2)
POINTS = Landmarks(MESH.faces[:60:3], RANDOM.dirichlet(np.ones(3), size=20))


def positions(points: Landmarks, mesh: TriangleMesh) -> FloatArray:
    corners = mesh.vertices[mesh.vertices_of(points.corners.ravel()).reshape(-1, 3)]
    found: FloatArray = np.einsum("nc,ncd->nd", points.barycentric, corners)
    return found


def test_images_on_a_permuted_copy_are_the_points_themselves() -> None:
    other, _ = shapes.permuted(MESH, seed=5)
    images = landmark_images(POINTS, registered(MESH, other), other)
    np.testing.assert_allclose(positions(images, other), positions(POINTS, MESH), atol=1e-5)
    assert images.barycentric.min() >= 0.0
    np.testing.assert_allclose(images.barycentric.sum(axis=1), 1.0)


def test_the_image_of_a_vertex_is_that_of_the_map() -> None:
    dense = registered(MESH, FINE)
    vertices = np.array([3, 99, 400])
    at = Landmarks(np.repeat(vertices[:, None], 3, axis=1), np.tile([0.0, 1.0, 0.0], (3, 1)))
    images = landmark_images(at, dense, FINE)
    np.testing.assert_array_equal(images.corners, dense.faces[vertices])
    np.testing.assert_array_equal(images.barycentric, dense.barycentric[vertices])


def test_images_return_there_and_back() -> None:
    dense = registered(MESH, FINE)
    assert dense.inverse is not None
    there = landmark_images(POINTS, dense, FINE)
    back = landmark_images(there, dense.inverse, MESH)
    apart = np.linalg.norm(positions(back, MESH) - positions(POINTS, MESH), axis=1)
    assert apart.mean() < 0.02 * np.sqrt(MESH.area)


def test_points_that_are_none() -> None:
    dense = registered(MESH, MESH)
    beyond = Landmarks(np.array([[0, 1, 9999]]), np.full((1, 3), 1 / 3))
    with pytest.raises(TransferError, match="vertex 9999 is not part"):
        landmark_images(beyond, dense, MESH)
    outside = Landmarks(np.array([[0, 1, 2]]), np.array([[1.5, -0.5, 0.0]]))
    with pytest.raises(TransferError, match="negative"):
        landmark_images(outside, dense, MESH)
