"""Transformations with known correspondence: scaling, noise, remeshing."""

import numpy as np
import pytest

from solver.arrays import IntArray
from solver.mesh import TriangleMesh, vertex_normals
from solver.shape.geodesics import GeodesicGraph
from synthetic.nearest_surface import NearestSurface
from synthetic.transformations import noisy, remeshed, scaled
from tests.solver.shapes import blob, icosphere, plane_grid
from tests.synthetic.surfaces import euler_characteristic, is_oriented


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
