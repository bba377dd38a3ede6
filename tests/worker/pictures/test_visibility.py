"""Points that a surface hides."""

import numpy as np
import pytest

from solver.arrays import BoolArray, FloatArray, IntArray
from tests.solver import shapes
from worker.pictures.visibility import CLEARANCE, hidden_points


def by_every_face(vertices: FloatArray, faces: IntArray, points: FloatArray) -> BoolArray:
    """(K,) whether a face is in front of a point, by barycentric coordinates in every face."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)[:, None]
    ab, ac, ap = b - a, c - a, points[:, None] - a

    def cross(one: FloatArray, other: FloatArray) -> FloatArray:
        product: FloatArray = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
        return product

    u, v = cross(ap, ac) / cross(ab, ac), cross(ab, ap) / cross(ab, ac)
    inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    depth = a[..., 2] + u * ab[..., 2] + v * ac[..., 2]
    hidden: BoolArray = (inside & (depth > points[:, None, 2] + CLEARANCE)).any(axis=1)
    return hidden


@pytest.mark.parametrize("seed", range(3))
def test_hidden_points_are_those_of_every_face(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = shapes.blob(3)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    vertices = mesh.scaled(1.0 / np.sqrt(mesh.area)).vertices @ rotation
    points = np.concatenate([vertices[::7], rng.uniform(-0.4, 0.4, size=(50, 3))])
    found = hidden_points(vertices, mesh.faces, points)
    assert 0 < found.sum() < len(points)
    np.testing.assert_array_equal(found, by_every_face(vertices, mesh.faces, points))


def test_nothing_is_hidden_without_faces() -> None:
    points = np.zeros((2, 3))
    assert not hidden_points(points, np.zeros((0, 3), dtype=np.int64), points).any()
