"""Nearest points of a surface, and their images."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from isomatch import Geometry, VertexMap
from isomatch._landmarks.surface_points import images, nearest_points
from scipy.spatial.transform import Rotation

from tests.client._landmarks.surfaces import blob, identity, moved, surface_samples

BLOB = blob()


@settings(max_examples=20)
@given(seed=st.integers(0, 2**31 - 1))
def test_no_point_of_the_surface_is_nearer(seed: int) -> None:
    positions = np.random.default_rng(seed).uniform(-2.5, 2.5, size=(3, 3))
    points = nearest_points(BLOB, positions)
    assert (points.weights >= 0.0).all()
    np.testing.assert_allclose(points.weights.sum(axis=1), 1.0)
    found = np.linalg.norm(points.positions(BLOB) - positions, axis=1)
    others = surface_samples(BLOB, 20_000, seed)
    sampled = np.linalg.norm(others - positions[:, None], axis=2).min(axis=1)
    assert (found <= sampled).all()
    np.testing.assert_allclose(found, sampled, atol=0.1)


def test_faces_edges_and_corners_of_a_triangle() -> None:
    triangle = Geometry(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), np.arange(3), None
    )
    positions = np.array([[0.2, 0.3, 5.0], [0.5, -2.0, 1.0], [1.0, 1.0, 0.0], [3.0, -1.0, 0.0]])
    expected = [[0.2, 0.3, 0.0], [0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]]
    found = nearest_points(triangle, positions).positions(triangle)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_points_of_the_surface_are_found_again() -> None:
    samples = surface_samples(BLOB, 50, seed=1)
    np.testing.assert_allclose(nearest_points(BLOB, samples).positions(BLOB), samples, atol=1e-12)


def test_images_under_a_rigid_motion() -> None:
    turn = Rotation.from_rotvec([0.4, -1.0, 2.0]).as_matrix()
    other = moved(BLOB, BLOB.vertices @ turn.T + [5.0, 1.0, -2.0])
    samples = surface_samples(BLOB, 30, seed=2)
    points = nearest_points(BLOB, samples)
    found = images(points, identity(BLOB), other).positions(other)
    np.testing.assert_allclose(found, samples @ turn.T + [5.0, 1.0, -2.0], atol=1e-9)


def test_the_image_stays_on_the_sheet_of_its_triangle() -> None:
    """Two sheets that nearly touch: the other one may be nearer to the mean of the corners."""
    grid = np.stack(np.meshgrid(np.arange(4.0), np.arange(4.0)), axis=2).reshape(-1, 2)
    rows = [4 * y + x for y in range(3) for x in range(3)]
    faces = np.array([(a, a + 1, a + 4) for a in rows] + [(a + 1, a + 5, a + 4) for a in rows])
    bent = np.column_stack([grid, 0.3 * (grid[:, 0] - 1.5) ** 2])
    flat = np.column_stack([grid, np.full(16, 0.25)])
    both = Geometry(np.vstack([bent, flat]), np.vstack([faces, faces + 16]), np.arange(32), None)
    sheet = Geometry(bent, faces, np.arange(16), None)
    middle = nearest_points(sheet, np.array([[1.5, 1.4, 0.0]]))
    found = images(middle, identity(sheet), both)
    assert (found.faces < 16).all()


def test_points_that_the_map_does_not_have_are_refused() -> None:
    samples = surface_samples(BLOB, 3, seed=3)
    points = nearest_points(BLOB, samples)
    whole = identity(BLOB)
    gone = whole.vertices != points.faces[1, 0]
    part = VertexMap(
        whole.vertices[gone], whole.images[gone], whole.faces[gone], whole.weights[gone]
    )
    with pytest.raises(ValueError, match=f"vertex {points.faces[1, 0]} is not part"):
        images(points, part, BLOB)
    none = np.zeros((0, 3))
    vertices_alone = VertexMap(whole.vertices, whole.images, none.astype(np.int64), none)
    with pytest.raises(ValueError, match="no images between vertices"):
        images(points, vertices_alone, BLOB)


def test_no_points_have_no_images() -> None:
    none = nearest_points(BLOB, np.zeros((0, 3)))
    assert images(none, identity(BLOB), BLOB).positions(BLOB).shape == (0, 3)
