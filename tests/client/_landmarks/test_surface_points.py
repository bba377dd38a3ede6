"""Nearest points of a surface."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from isomatch import Geometry
from isomatch._landmarks.surface_points import nearest_points

from tests.client._landmarks.surfaces import blob, surface_samples

BLOB = blob()


@settings(max_examples=20)
@given(seed=st.integers(0, 2**31 - 1))
def test_no_point_of_the_surface_is_nearer(seed: int) -> None:
    positions = np.random.default_rng(seed).uniform(-2.5, 2.5, size=(3, 3))
    found = np.linalg.norm(nearest_points(BLOB, positions) - positions, axis=1)
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
    found = nearest_points(triangle, positions)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_points_of_the_surface_are_found_again() -> None:
    samples = surface_samples(BLOB, 50, seed=1)
    np.testing.assert_allclose(nearest_points(BLOB, samples), samples, atol=1e-12)


def test_no_positions_have_no_nearest_points() -> None:
    assert nearest_points(BLOB, np.zeros((0, 3))).shape == (0, 3)
