"""Transformed surfaces: of the topology that is claimed, their points where they are said to be."""

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.mesh import TriangleMesh, vertex_normals
from solver.shape import GeodesicMetric, farthest_point_sampling
from solver.shape.geodesics import GeodesicGraph
from synthetic import articulated
from synthetic.nearest_surface import NearestSurface
from synthetic.texture import painted
from synthetic.topology import glued, near_in_space, punched
from synthetic.transformations import Transformed, noisy, remeshed, scaled
from tests.solver.shapes import blob, icosphere, plane_grid, torus


def euler_characteristic(mesh: TriangleMesh) -> int:
    return mesh.n_vertices - len(mesh.edges) + mesh.n_faces


def is_oriented(mesh: TriangleMesh) -> bool:
    """Whether no edge is passed twice in one direction."""
    edges = mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return len(np.unique(edges, axis=0)) == len(edges)


def assert_kept_in_place(original: TriangleMesh, transformed: Transformed) -> None:
    kept = transformed.kept
    np.testing.assert_array_equal(
        transformed.mesh.vertices[transformed.image[kept]], original.vertices[kept]
    )


def spread(mesh: TriangleMesh, count: int) -> IntArray:
    return np.linspace(0, mesh.n_vertices - 1, count).astype(np.int64)


def test_scaling_multiplies_lengths() -> None:
    original = blob()
    found = scaled(original, 2.5)
    assert found.mesh.area == pytest.approx(2.5**2 * original.area, rel=1e-12)
    np.testing.assert_array_equal(found.mesh.faces, original.faces)
    np.testing.assert_array_equal(found.image, np.arange(original.n_vertices))


def test_noise_is_along_normals_and_in_units_of_edges() -> None:
    original = icosphere(4)
    found = noisy(original, 0.2, seed=7)
    np.testing.assert_array_equal(found.mesh.vertices, noisy(original, 0.2, seed=7).mesh.vertices)
    moved = found.mesh.vertices - original.vertices
    normals = vertex_normals(original.vertices, original.faces)
    heights = np.einsum("vd,vd->v", moved, normals)
    np.testing.assert_allclose(moved, heights[:, None] * normals, atol=1e-12)
    ends = original.vertices[original.edges]
    edge = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).mean()
    assert heights.std() == pytest.approx(0.2 * edge, rel=0.05)
    assert abs(heights.mean()) < 0.02 * edge


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


def test_remeshing_keeps_the_surface() -> None:
    original = blob(3)
    found = remeshed(original, 500, seed=1)
    assert found.mesh.n_vertices == 500
    assert found.mesh.closed
    assert euler_characteristic(found.mesh) == 2
    assert is_oriented(found.mesh)
    assert found.mesh.area == pytest.approx(original.area, rel=0.03)
    onto = NearestSurface(original).nearest(found.mesh.vertices).points
    np.testing.assert_allclose(onto, found.mesh.vertices, atol=1e-9)
    points = spread(original, 20)
    before = GeodesicGraph(original).distances(points)[:, points]
    after = GeodesicGraph(found.mesh).distances(found.image[points])[:, found.image[points]]
    edge = np.sqrt(original.area / 500)
    assert np.abs(after - before).mean() < 0.6 * edge
    other = remeshed(original, 500, seed=2).mesh
    assert np.linalg.norm(other.vertices - found.mesh.vertices, axis=1).max() > edge


def test_a_surface_with_a_boundary_is_not_remeshed() -> None:
    with pytest.raises(ValueError, match="closed"):
        remeshed(plane_grid(), 100)


def test_the_nearest_points_of_a_sphere_are_in_the_same_direction() -> None:
    sphere = icosphere(4)
    outside = 1.5 * icosphere(2).vertices
    found = NearestSurface(sphere).nearest(outside)
    np.testing.assert_allclose(found.points, outside / 1.5, atol=0.02)
    np.testing.assert_allclose(found.normals, outside / 1.5, atol=0.02)


def test_paint_is_smooth_and_symmetric_only_when_asked() -> None:
    shape = articulated("cat", "standing", 800)
    mirrored = shape.rest * np.array([-1.0, 1.0, 1.0])
    ends = TriangleMesh(shape.vertices, shape.faces, np.arange(800)).edges
    for symmetric in (False, True):
        colors = painted(shape.rest, symmetric)
        assert colors.min() >= 0.0
        assert colors.max() <= 1.0
        assert colors.std(axis=0).min() > 0.05
        steps = np.linalg.norm(colors[ends[:, 0]] - colors[ends[:, 1]], axis=1)
        lengths = np.linalg.norm(shape.rest[ends[:, 0]] - shape.rest[ends[:, 1]], axis=1)
        assert (steps < 4.5 * lengths).all()
    difference = painted(shape.rest) - painted(mirrored)
    aside = np.abs(shape.rest[:, 0]) > 0.08
    assert np.linalg.norm(difference[aside], axis=1).min() > 0.02
    np.testing.assert_allclose(painted(shape.rest, True), painted(mirrored, True), atol=1e-12)
