"""Distances between near points of a part, and what maps to the whole make of them."""

import numpy as np
import pytest

from solver.arrays import FloatArray, IntArray
from solver.mesh import triangle_mesh
from solver.registration.partial.near_distances import NearDistances
from solver.registration.surface import smooth_surface
from solver.shape import Shape
from tests.solver.shapes import icosphere


@pytest.fixture(scope="module")
def whole() -> Shape:
    return Shape(icosphere(3))


@pytest.fixture(scope="module")
def near(whole: Shape) -> NearDistances:
    """Of the whole sphere, in another unit."""
    part = Shape(triangle_mesh(5.0 * whole.mesh.vertices, whole.mesh.faces))
    return NearDistances.of(part, smooth_surface(part).samples.vertices)


def test_the_nearest_pairs_are_taken(whole: Shape, near: NearDistances) -> None:
    """On a sphere of unit area, those within an angle: cos θ = 0 for half of all pairs."""
    points = whole.mesh.vertices[near.points]
    angles = np.arccos((points[near.first] * points[near.second]).sum(axis=1))
    assert angles.max() == pytest.approx(np.pi / 2, rel=0.1)
    np.testing.assert_allclose(near.lengths, angles / np.sqrt(4.0 * np.pi), rtol=0.05)


def nearest(whole: Shape, places: FloatArray) -> IntArray:
    vertices = whole.mesh.vertices
    found: IntArray = np.linalg.norm(places[:, None] - vertices, axis=2).argmin(axis=1)
    return found


def test_isometries_change_nothing(whole: Shape, near: NearDistances) -> None:
    """The identity and a reflection."""
    mirrored = nearest(whole, whole.mesh.vertices * [-1.0, 1.0, 1.0])
    assert near.change(whole, np.arange(whole.n_vertices), 1.0) == pytest.approx(0.0, abs=1e-12)
    assert near.change(whole, mirrored, 1.0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("scale", [0.8, 1.3])
def test_a_wrong_scale_changes_all_distances_alike(
    whole: Shape, near: NearDistances, scale: float
) -> None:
    change = near.change(whole, np.arange(whole.n_vertices), scale)
    assert change == pytest.approx(abs(scale - 1.0))


def test_a_collapse_and_a_tear_change_much(whole: Shape, near: NearDistances) -> None:
    """All at one vertex; and one half of the sphere turned by a right angle against the other."""
    vertices = whole.mesh.vertices
    turned = vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    torn = nearest(whole, np.where(vertices[:, :1] > 0.0, turned, vertices))
    assert near.change(whole, np.zeros(len(vertices), dtype=np.int64), 1.0) == pytest.approx(1.0)
    assert near.change(whole, torn, 1.0) > 0.2
