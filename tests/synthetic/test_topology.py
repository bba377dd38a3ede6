"""Holes and handles: the topology changes as stated, and other vertices stay in place."""

import numpy as np
import pytest

from solver.mesh import TriangleMesh
from solver.shape import GeodesicMetric, farthest_point_sampling
from solver.shape.geodesics import GeodesicGraph
from synthetic import articulated
from synthetic.topology import glued, near_in_space, punched
from synthetic.transformations import Transformed
from tests.solver.shapes import icosphere, torus
from tests.synthetic.surfaces import euler_characteristic, is_oriented


def assert_kept_in_place(original: TriangleMesh, transformed: Transformed) -> None:
    kept = transformed.kept
    np.testing.assert_array_equal(
        transformed.mesh.vertices[transformed.image[kept]], original.vertices[kept]
    )


@pytest.mark.parametrize("radius", [0.0, 0.2, 0.4])
def test_every_hole_takes_one_from_the_euler_characteristic(radius: float) -> None:
    original = icosphere(4)
    centres = np.array([0, 3, 500])
    found = punched(original, centres, radius)
    assert euler_characteristic(found.mesh) == 2 - len(centres)
    assert found.mesh.components == 1
    assert not found.mesh.closed
    assert not found.kept[centres].any()
    assert_kept_in_place(original, found)
    apart = np.linalg.norm(found.mesh.vertices[found.image] - original.vertices, axis=1)
    assert apart.max() <= 0.4 + 0.2
    assert 4.0 * np.pi - found.mesh.area > 3 * np.pi * radius**2 * 0.9


@pytest.mark.parametrize("radius", [0.0, 0.3])
@pytest.mark.parametrize(("original", "genus"), [(icosphere(4), 0), (torus(48, 24), 1)])
def test_gluing_adds_a_handle(original: TriangleMesh, genus: int, radius: float) -> None:
    metric = GeodesicMetric(GeodesicGraph(original))
    pairs = farthest_point_sampling(metric, 4).indices.reshape(2, 2)
    found = glued(original, pairs, radius)
    assert found.mesh.closed
    assert found.mesh.components == 1
    assert is_oriented(found.mesh)
    assert euler_characteristic(found.mesh) == 2 - 2 * (genus + 2)
    assert_kept_in_place(original, found)


def test_glued_points_are_near_one_another() -> None:
    shape = articulated("human", "standing", 800)
    original = TriangleMesh(shape.vertices, shape.faces, np.arange(800))
    reach = 0.6 * np.sqrt(original.area)
    pairs = near_in_space(original, 2, reach)
    assert pairs.shape == (2, 2)
    before = GeodesicGraph(original).distances(pairs[:, 0])[[0, 1], pairs[:, 1]]
    assert (before >= reach).all()
    found = glued(original, pairs, 0.0)
    ends = found.image[pairs]
    after = GeodesicGraph(found.mesh).distances(ends[:, 0])[[0, 1], ends[:, 1]]
    assert (after < 0.4 * before).all()


def test_parts_that_touch_are_not_glued() -> None:
    with pytest.raises(ValueError, match="touch"):
        glued(icosphere(3), np.array([[0, 100], [100, 300]]), 0.0)


def test_half_a_sphere_or_more_is_a_disc_but_all_of_it_is_not() -> None:
    assert euler_characteristic(punched(icosphere(3), np.array([0]), 2.0).mesh) == 1
    with pytest.raises(ValueError, match="not a disc"):
        punched(icosphere(3), np.array([0]), 4.0)
